#include "support/reference/quality_scenes.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "ingest/open_source.h"

namespace kiln::test {
namespace {

const glm::dvec3 kSkinColor{0.93, 0.74, 0.6}, kBoneColor{0.88, 0.80, 0.64}, kShellColor{0.9, 0.55, 0.4};
constexpr double kSolid = 0.95;  // opacity per mean spacing
constexpr double kTranslucent = 0.12;
constexpr double kFovDeg = 50;

}  // namespace

const char* nameOf(Material material) {
  switch (material) {
    case Material::kSkin:
      return "skin";
    case Material::kBone:
      return "bone";
    case Material::kBoneInSkin:
      break;
  }
  return "bone_in_skin";
}

const char* nameOf(Projection projection) {
  return projection == Projection::kPerspective ? "perspective" : "orthographic";
}

const std::vector<QualityVolume>& qualityVolumes() {
  // Both scans of heads hold Hounsfield units + 1024.
  static const std::vector<QualityVolume> volumes = {
      {"cthead",
       "cthead_256x256x113_u16le.nrrd",
       {-0.5, -1, -0.3},
       {0, 0, -1},
       {110, 30, 60},
       {480, 640},
       {1150, 1350},
       {400, 550, 750, 900}},
      {"vhm_head",
       "vhm_head_512x512x245_i16le.nrrd",
       {-0.5, -1, 0.3},
       {0, 0, 1},
       {265, 150, 95},
       {480, 640},
       {1150, 1350},
       {400, 550, 750, 900}},
      {"engine",
       "raw/engine.nhdr",
       {-0.6, -0.8, 0.5},
       {0, 0, 1},
       {41, 15, 96},
       {65, 90},
       {165, 195},
       {40, 60, 80, 105}},
  };
  return volumes;
}

const QualityVolume& qualityVolume(std::string_view name) {
  const std::vector<QualityVolume>& all = qualityVolumes();
  return *std::find_if(all.begin(), all.end(), [&](const QualityVolume& volume) { return volume.name == name; });
}

DenseVolume readVolume(const std::filesystem::path& file) {
  const auto source = openSource(file);
  DenseVolume volume{source->info().geometry, source->info().type, {}};
  volume.voxels.resize(static_cast<std::size_t>(volume.geometry.dims.count()) * sizeOf(volume.type));
  source->read(boxOf(volume.geometry.dims), volume.voxels);
  source->finish();
  return volume;
}

TransferFunction transferFunctionOf(const QualityVolume& volume, Material material) {
  if (material == Material::kSkin) return {0, {{volume.skin[0], kSkinColor, 0}, {volume.skin[1], kSkinColor, kSolid}}};
  TransferFunction out{0, {{volume.bone[0], kBoneColor, 0}, {volume.bone[1], kBoneColor, kSolid}}};
  if (material == Material::kBone) return out;
  const double* shell = volume.shell;
  out.points.insert(out.points.begin(), {{shell[0], kShellColor, 0},
                                         {shell[1], kShellColor, kTranslucent},
                                         {shell[2], kShellColor, kTranslucent},
                                         {shell[3], kShellColor, 0}});
  return out;
}

Camera cameraOf(const QualityVolume& volume, const VolumeGeometry& geometry, Projection projection, double px_per_voxel,
                int image_px) {
  const Extent3& n = geometry.dims;
  Camera camera;
  camera.projection = projection;
  camera.target = geometry.worldOf(px_per_voxel > 1 ? volume.close_up : glm::dvec3(n.x - 1, n.y - 1, n.z - 1) / 2.0);
  camera.up = volume.up;
  camera.height = image_px / px_per_voxel * geometry.shortestEdge();
  camera.fov_deg = kFovDeg;
  // Parallel rays begin in front of the whole volume wherever the eye is.
  const double distance = camera.height / 2 / std::tan(kFovDeg / 2 * std::numbers::pi / 180);
  camera.eye = camera.target + distance * glm::normalize(volume.from);
  return camera;
}

}  // namespace kiln::test
