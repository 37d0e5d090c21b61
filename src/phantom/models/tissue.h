// Materials of a phantom and their values in a scanner. A table of values describes one machine, so a figure is a CT
// and an MR volume.
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

/// A name for people: "cortical bone".
std::string_view nameOf(Tissue tissue);

/// Value of each tissue, and noise of the machine. unit: voxel values.
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
