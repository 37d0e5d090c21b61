#include "convert/stream/half_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "grid/openvdb_glue.h"

namespace kiln {
namespace {

constexpr float kLargestHalf = 65504;

float nearestHalf(float exact) {
  return static_cast<float>(openvdb::math::half(std::clamp(exact, -kLargestHalf, kLargestHalf)));
}

template <class T>
HalfLoss roundAll(std::span<T> values) {
  HalfLoss out;
  for (T& value : values) {
    const auto exact = static_cast<float>(value);
    if (!std::isfinite(exact)) continue;
    const float half = nearestHalf(exact);
    out.include({std::abs(static_cast<double>(half) - static_cast<double>(exact)), std::abs(exact), std::abs(half)});
    value = static_cast<T>(half);
  }
  return out;
}

}  // namespace

void HalfLoss::include(const HalfLoss& other) {
  largest_error = std::max(largest_error, other.largest_error);
  largest_exact = std::max(largest_exact, other.largest_exact);
  largest_rounded = std::max(largest_rounded, other.largest_rounded);
}

std::string HalfLoss::warning() const {
  // Up to here the nearest half is the largest half.
  constexpr double kFirstCut = 65520;
  constexpr const char* kRemedy = "convert without --half, or scale the values first";
  if (largest_exact >= kFirstCut)
    return fmt::format("--half: values beyond {} became {} (found magnitudes up to {:g}); {}", kLargestHalf,
                       kLargestHalf, largest_exact, kRemedy);
  if (largest_exact > 0 && largest_rounded == 0)
    return fmt::format("--half: all values became 0 (found magnitudes up to {:g}; a half holds 6e-8 and more); {}",
                       largest_exact, kRemedy);
  return {};
}

HalfLoss roundToHalf(VoxelType type, std::span<std::byte> voxels) {
  return withVoxelType(type, [&]<class T>(std::type_identity<T>) -> HalfLoss {
    if constexpr (sizeof(T) == 1) return {};  // a half holds all 8-bit values
    return roundAll(std::span(reinterpret_cast<T*>(voxels.data()), voxels.size() / sizeof(T)));
  });
}

HalfSource::HalfSource(std::unique_ptr<VolumeSource> exact) : WrappedSource(std::move(exact)) {
  if (sizeOf(info_.type) > 4 || info_.type == VoxelType::i32 || info_.type == VoxelType::u32) {
    throw Error(ErrorCode::kUsage, "--half: rounds volumes of 16-bit integers and of floats; this one has " +
                                       std::string(nameOf(info_.type)));
  }
  info_.format += ", rounded to half";
  // Exports find the empty voxels by this value, so the background is rounded as voxels are.
  if (sizeOf(info_.type) > 1 && std::isfinite(info_.background))
    info_.background = static_cast<double>(nearestHalf(static_cast<float>(info_.background)));
}

void HalfSource::read(const VoxelBox& box, std::span<std::byte> out) {
  WrappedSource::read(box, out);
  const HalfLoss loss = roundToHalf(info_.type, out);
  const std::scoped_lock lock(mutex_);
  loss_.include(loss);
}

HalfLoss HalfSource::loss() const {
  const std::scoped_lock lock(mutex_);
  return loss_;
}

}  // namespace kiln
