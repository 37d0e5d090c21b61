// OME-Zarr has a scale and a translation along each axis, and the anatomical direction of an axis (RFC-4). Directions
// beside the axes of the world are lost; the scan's own axes then are the axes of its world.
// Source: ngff.openmicroscopy.org, version 0.5; zarr-specs, docs/v3/core.
#include "export/zarr/ome_metadata.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "base/text.h"
#include "export/zarr/blosc_pack.h"
#include "grid/declared_look.h"

namespace kiln {
namespace {
using nlohmann::ordered_json;

// Attributes beside "ome" are free for other programs (OME-Zarr 0.5).
const ordered_json::json_pointer kContentsAt("/attributes/kiln/export");

constexpr std::array<const char*, 3> kAxisNames = {"x", "y", "z"};

// The spelling of units in OME's list.
std::string omeUnit(const std::string& unit) {
  constexpr std::pair<const char*, const char*> kNames[] = {
      {"pm", "picometer"},  {"angstrom", "angstrom"}, {"nm", "nanometer"}, {"um", "micrometer"},
      {"mm", "millimeter"}, {"cm", "centimeter"},     {"in", "inch"},      {"dm", "decimeter"},
      {"ft", "foot"},       {"yd", "yard"},           {"m", "meter"},      {"km", "kilometer"}};
  for (const auto& [name, spelled] : kNames)
    if (unit == name) return spelled;
  return "";
}

const char* zarrTypeName(VoxelType type) {
  constexpr const char* kNames[] = {"uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64"};
  return kNames[static_cast<std::size_t>(type)];
}

/// An axis of the volume that runs along an axis of the patient.
struct AnatomicalAxis {
  int row = 0;
  double sign = 1;
};

std::optional<AnatomicalAxis> anatomicalAxis(const glm::dvec3& direction) {
  for (int row = 0; row < 3; ++row)
    if (direction[row] != 0 && direction[(row + 1) % 3] == 0 && direction[(row + 2) % 3] == 0)
      return AnatomicalAxis{row, direction[row] < 0 ? -1.0 : 1.0};
  return std::nullopt;
}

std::string orientationText(const AnatomicalAxis& axis) {
  constexpr const char* kRas[3][2] = {{"left-to-right", "right-to-left"},
                                      {"posterior-to-anterior", "anterior-to-posterior"},
                                      {"inferior-to-superior", "superior-to-inferior"}};
  return kRas[axis.row][axis.sign < 0 ? 1 : 0];
}

// The anatomical axes of a volume; nothing if an axis lies between anatomical axes.
std::optional<std::array<AnatomicalAxis, 3>> anatomyOf(const VolumeGeometry& geometry) {
  if (geometry.frame == PatientFrame::kUnknown) return std::nullopt;
  const glm::dmat4 affine = affineIn(PatientFrame::kRas, geometry);
  std::array<AnatomicalAxis, 3> out;
  for (int axis = 0; axis < 3; ++axis) {
    const std::optional<AnatomicalAxis> found = anatomicalAxis(glm::dvec3(affine[axis]));
    if (!found) return std::nullopt;
    out[static_cast<std::size_t>(axis)] = *found;
  }
  return out;
}

// The position of the first voxel along the volume's own axes.
glm::dvec3 translationOf(const VolumeGeometry& geometry) {
  const glm::dvec3 origin = geometry.worldOf({0, 0, 0});
  if (const auto anatomy = anatomyOf(geometry)) {
    const glm::dvec3 ras(affineIn(PatientFrame::kRas, geometry)[3]);
    glm::dvec3 out;
    for (int axis = 0; axis < 3; ++axis) {
      const AnatomicalAxis& along = (*anatomy)[static_cast<std::size_t>(axis)];
      out[axis] = along.sign * ras[along.row];
    }
    return out;
  }
  if (geometry.isUnturned()) return origin;
  glm::dvec3 out;
  for (int axis = 0; axis < 3; ++axis)
    out[axis] = glm::dot(glm::normalize(glm::dvec3(geometry.world_from_index[axis])), origin);
  return out;
}

// Numbers of z, y and x.
ordered_json zyx(const glm::dvec3& numbers) { return {numbers.z, numbers.y, numbers.x}; }
ordered_json zyx(const Extent3& numbers) { return {numbers.z, numbers.y, numbers.x}; }

ordered_json axesJson(const VolumeGeometry& geometry, ExportNotes& notes) {
  const std::string unit = omeUnit(geometry.unit);
  if (!geometry.unit.empty() && unit.empty())
    notes.push_back("OME-Zarr has no such unit of length; lengths are written without a unit");
  const auto anatomy = anatomyOf(geometry);
  const bool turned = !anatomy && (geometry.frame != PatientFrame::kUnknown || !geometry.isUnturned());
  if (turned)
    notes.push_back(
        "OME-Zarr holds spacing, origin and the directions of axes along those of a patient; the "
        "directions of this volume are lost");
  ordered_json out = ordered_json::array();
  for (int axis = 2; axis >= 0; --axis) {
    ordered_json one = {{"name", kAxisNames[static_cast<std::size_t>(axis)]}, {"type", "space"}};
    if (!unit.empty()) one["unit"] = unit;
    if (anatomy)
      one["orientation"] = {{"type", "anatomical"},
                            {"value", orientationText((*anatomy)[static_cast<std::size_t>(axis)])}};
    out.push_back(one);
  }
  return out;
}

// The colours of labels, as numbers from 0 to 255.
ordered_json colorsJson(const std::vector<DeclaredLook::Label>& labels) {
  ordered_json out = ordered_json::array();
  for (const auto& [label, color] : labels)
    out.push_back({{"label-value", label}, {"rgba", {color.red, color.green, color.blue, color.alpha}}});
  return out;
}

// The window and the colour of the single channel, as OMERO writes them. The slider of a window ends at `min` and
// `max`.
ordered_json omeroJson(const DeclaredLook::Ramp& ramp, const OmeTitle& title) {
  const auto bounded = [](double end, double slider) { return std::isfinite(slider) ? slider : end; };
  return {{"channels",
           {{{"label", utf8OfName(title.name)},
             {"color", textOf(ramp.color).substr(1)},
             {"active", true},
             {"window",
              {{"min", std::min(ramp.begin, bounded(ramp.begin, title.range.lo))},
               {"max", std::max(ramp.end, bounded(ramp.end, title.range.hi))},
               {"start", ramp.begin},
               {"end", ramp.end}}}}}}};
}

template <class T>
ordered_json fillJson(T value) {
  if constexpr (std::is_floating_point_v<T>) {
    if (std::isnan(value)) return "NaN";
    if (std::isinf(value)) return value > 0 ? "Infinity" : "-Infinity";
  }
  return value;
}

}  // namespace

std::vector<std::string> omeArrays(const std::string& header) {
  const ordered_json json = ordered_json::parse(header, nullptr, /*allow_exceptions=*/false);
  std::vector<std::string> out;
  const ordered_json::json_pointer images("/attributes/ome/multiscales");
  if (json.is_discarded() || !json.contains(images) || !json[images].is_array()) return out;
  for (const ordered_json& image : json[images]) {
    if (!image.is_object() || !image.contains("datasets") || !image["datasets"].is_array()) continue;
    for (const ordered_json& dataset : image["datasets"])
      if (dataset.is_object() && dataset.contains("path") && dataset["path"].is_string())
        out.push_back(dataset["path"].get<std::string>());
  }
  return out;
}

std::string exportedContents(const std::string& header) {
  const ordered_json json = ordered_json::parse(header, nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded() || !json.contains(kContentsAt) || !json[kContentsAt].is_string()) return {};
  return json[kContentsAt].get<std::string>();
}

std::string omeGroupText(const std::vector<ExportedVolume>& volumes, const OmeTitle& title, ExportNotes& notes) {
  ordered_json datasets = ordered_json::array();
  for (std::size_t i = 0; i < volumes.size(); ++i) {
    const VolumeGeometry& geometry = volumes[i].geometry;
    datasets.push_back({{"path", std::to_string(i)},
                        {"coordinateTransformations",
                         {{{"type", "scale"}, {"scale", zyx(geometry.spacing())}},
                          {{"type", "translation"}, {"translation", zyx(translationOf(geometry))}}}}});
  }
  const bool labels = volumes.front().volume_class == VolumeClass::kLabels;
  ordered_json ome = {{"version", "0.5"},
                      {"multiscales",
                       {{{"name", utf8OfName(title.name)},
                         {"axes", axesJson(volumes.front().geometry, notes)},
                         {"datasets", datasets},
                         {"type", labels ? "mode" : "mean"}}}}};
  if (labels) ome["image-label"] = {{"version", "0.5"}};
  if (labels && !title.look.labels.empty()) ome["image-label"]["colors"] = colorsJson(title.look.labels);
  if (!labels && title.look.ramp) ome["omero"] = omeroJson(*title.look.ramp, title);
  ordered_json out = {{"zarr_format", 3}, {"node_type", "group"}, {"attributes", {{"ome", ome}}}};
  out[kContentsAt] = title.contents;
  return out.dump(2) + "\n";
}

std::string zarrArrayText(const ExportedVolume& volume, const Extent3& shard, const Extent3& chunk) {
  const std::size_t voxel_bytes = sizeOf(volume.type);
  const ordered_json bytes = {{"name", "bytes"}, {"configuration", {{"endian", "little"}}}};
  const ordered_json blosc = {{"name", "blosc"},
                              {"configuration",
                               {{"typesize", voxel_bytes},
                                {"cname", "zstd"},
                                {"clevel", kBloscLevel},
                                {"shuffle", voxel_bytes > 1 ? "shuffle" : "noshuffle"},
                                {"blocksize", 0}}}};
  const ordered_json sharding = {{"name", "sharding_indexed"},
                                 {"configuration",
                                  {{"chunk_shape", zyx(chunk)},
                                   {"codecs", {bytes, blosc}},
                                   {"index_codecs", {bytes, {{"name", "crc32c"}}}},
                                   {"index_location", "end"}}}};
  const ordered_json fill = withVoxelType(
      volume.type, [&]<class T>(std::type_identity<T>) { return fillJson(static_cast<T>(volume.background)); });
  const ordered_json out = {{"zarr_format", 3},
                            {"node_type", "array"},
                            {"shape", zyx(volume.geometry.dims)},
                            {"data_type", zarrTypeName(volume.type)},
                            {"chunk_grid", {{"name", "regular"}, {"configuration", {{"chunk_shape", zyx(shard)}}}}},
                            {"chunk_key_encoding", {{"name", "default"}, {"configuration", {{"separator", "/"}}}}},
                            {"fill_value", fill},
                            {"codecs", ordered_json::array({sharding})},
                            {"attributes", ordered_json::object()},
                            {"dimension_names", {"z", "y", "x"}}};
  return out.dump(2) + "\n";
}

}  // namespace kiln
