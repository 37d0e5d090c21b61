// Scenes for judging pictures of real volumes: typical subjects (skin, bone, bone through translucent skin), from a
// quarter of a pixel to eight pixels a voxel.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "scene/camera/camera.h"
#include "scene/transfer/transfer_function.h"
#include "support/volumes/procedural.h"

namespace kiln::test {

enum class Material { kSkin, kBone, kBoneInSkin };
inline constexpr Material kMaterials[] = {Material::kSkin, Material::kBone, Material::kBoneInSkin};
const char* nameOf(Material material);
const char* nameOf(Projection projection);

/// A volume of the test data with its views.
struct QualityVolume {
  std::string name;
  std::filesystem::path file;  // relative to the data folder
  glm::dvec3 from;             // towards the eye. unit: world, any length
  glm::dvec3 up;
  glm::dvec3 close_up;  // target of the camera if the picture shows only a part. unit: index
  /// Opacity rises from zero to a solid's over each of these intervals; the shell is thin: transparent on both sides.
  double skin[2], bone[2], shell[4];
};

/// "cthead", "vhm_head", "engine".
const std::vector<QualityVolume>& qualityVolumes();
/// requires: a name of the list.
const QualityVolume& qualityVolume(std::string_view name);

/// Reads the whole file into memory. throws: all errors of openSource.
DenseVolume readVolume(const std::filesystem::path& file);

TransferFunction transferFunctionOf(const QualityVolume& volume, Material material);

/// Looks at the volume's middle up to one pixel a voxel, else at its close-up. `px_per_voxel` refers to the smallest
/// spacing, in perspective at the target.
Camera cameraOf(const QualityVolume& volume, const VolumeGeometry& geometry, Projection projection, double px_per_voxel,
                int image_px);

}  // namespace kiln::test
