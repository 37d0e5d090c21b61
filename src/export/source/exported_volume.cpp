#include "export/source/exported_volume.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>
#include <span>

#include "base/error.h"
#include "grid/shared_world.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

std::string voxelText(const VoxelCoord& voxel) { return fmt::format("{},{},{}", voxel.x, voxel.y, voxel.z); }

}  // namespace

ExportedVolume exportedVolume(const StoreReader& store, int level, const std::optional<VoxelBox>& region) {
  const Manifest& manifest = store.manifest();
  const VolumeGeometry& geometry = store.level(level).geometry;
  const VoxelBox whole = boxOf(manifest.geometry().dims);
  ExportedVolume out{level, boxOf(geometry.dims), geometry, manifest.type, manifest.volume_class, manifest.background};
  if (const std::string unit = unitName(geometry.unit); !unit.empty()) out.geometry.unit = unit;
  if (!region) return out;
  const VoxelBox shown = intersection(*region, whole);
  if (shown.empty())
    throw Error(ErrorCode::kUsage, store.path(), "--region",
                fmt::format("must hold voxels of the volume, which is from 0,0,0 to {} (found {} to {})",
                            voxelText(whole.hi), voxelText(region->lo), voxelText(region->hi)));
  out.box = intersection(coarseBox(shown, manifest.spanOf(level)), boxOf(geometry.dims));
  out.geometry.dims = out.box.extent();
  const glm::dvec3 origin = geometry.worldOf({out.box.lo.x, out.box.lo.y, out.box.lo.z});
  out.geometry.world_from_index[3] = glm::dvec4(origin, 1);
  return out;
}

std::string identityOf(const StoreReader& store, const ExportedVolume& volume) {
  const VoxelBox& box = volume.box;
  const VolumeGeometry& place = volume.geometry;
  return fmt::format("index {}, {} {}, background {}, level {}, {},{},{} to {},{},{}, at {}, unit {}, frame {}",
                     toHex(store.manifest().index_checksum), nameOf(volume.type), static_cast<int>(volume.volume_class),
                     volume.background, volume.level, box.lo.x, box.lo.y, box.lo.z, box.hi.x, box.hi.y, box.hi.z,
                     fmt::join(std::span(glm::value_ptr(place.world_from_index), 16), " "), place.unit,
                     static_cast<int>(place.frame));
}

glm::dmat4 affineIn(PatientFrame frame, const VolumeGeometry& geometry) {
  VolumeGeometry world;
  world.frame = frame;
  return worldChange(geometry, world).of(geometry.world_from_index);
}

VolumeGeometry withUnitOf(std::initializer_list<std::string_view> units, const VolumeGeometry& geometry,
                          ExportNotes& notes) {
  VolumeGeometry out = geometry;
  if (geometry.unit.empty() || std::find(units.begin(), units.end(), geometry.unit) != units.end()) return out;
  const std::optional<LengthRatio> ratio = lengthRatio(geometry.unit, *units.begin());
  if (!ratio) {
    out.unit.clear();
    notes.push_back(
        fmt::format("the format has no unit {}; its lengths are written without a unit", inQuotes(geometry.unit)));
    return out;
  }
  out.unit = *units.begin();
  out.world_from_index = WorldChange{false, *ratio}.of(out.world_from_index);
  notes.push_back(
      fmt::format("the format has no unit {}; lengths are written in {}", inQuotes(geometry.unit), out.unit));
  return out;
}

bool isPlacedBySpacing(const VolumeGeometry& geometry) {
  return geometry.isUnturned() && geometry.worldOf({0, 0, 0}) == glm::dvec3(0);
}

std::string extentText(const ExportedVolume& volume) {
  const Extent3& dims = volume.geometry.dims;
  return fmt::format("{} x {} x {} voxels of {}", dims.x, dims.y, dims.z, nameOf(volume.type));
}

}  // namespace kiln
