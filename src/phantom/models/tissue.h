// What a phantom is made of, and the value that a scanner would give it. A tissue is a name; the tables of values say
// how one machine sees it, so the same figure is a CT and an MR volume.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace kiln::phantom {

enum class Tissue : std::uint8_t {
  kAir,
  kSkin,
  kFat,
  kMuscle,
  kTendon,
  kCartilage,
  kCorticalBone,
  kMarrow,
  kTooth,
  kLung,
  kBlood,
  kHeart,
  kVessel,
  kLiver,
  kSpleen,
  kPancreas,
  kKidneyCortex,
  kKidneyMedulla,
  kGland,
  kGutWall,
  kGutContent,
  kFluid,
  kGreyMatter,
  kWhiteMatter,
  kEye,
  kLens,
  kAluminium,
  kIron,
};
inline constexpr std::size_t kTissueCount = 28;

/// "cortical bone", for people.
std::string_view nameOf(Tissue tissue);

/// The value of each tissue, and the noise of the machine. unit: voxel values.
struct ValueTable {
  std::array<float, kTissueCount> values{};
  float noise_sigma = 0;
  /// Values are clamped to [0, highest].
  float highest = 0;
  float of(Tissue tissue) const { return values[static_cast<std::size_t>(tissue)]; }
};

/// 12-bit CT: Hounsfield units + 1024, so air is 24 and water 1024.
const ValueTable& ctValues();
/// T1-weighted MR: fat, skin and white matter bright, fluid dark, cortical bone and air nearly black.
const ValueTable& mrValues();
/// 8-bit industrial CT of a casting.
const ValueTable& castingValues();

}  // namespace kiln::phantom
