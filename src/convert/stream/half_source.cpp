#include "convert/stream/half_source.h"

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "grid/openvdb_glue.h"

namespace kiln {
namespace {

constexpr float kLargestHalf = 65504;

template <class T>
double roundAll(std::span<T> values) {
  double largest = 0;
  for (T& value : values) {
    const auto exact = static_cast<float>(value);
    if (!std::isfinite(exact)) continue;
    const auto half = static_cast<float>(openvdb::math::half(std::clamp(exact, -kLargestHalf, kLargestHalf)));
    largest = std::max(largest, std::abs(static_cast<double>(half) - static_cast<double>(exact)));
    value = static_cast<T>(half);
  }
  return largest;
}

}  // namespace

double roundToHalf(VoxelType type, std::span<std::byte> voxels) {
  return withVoxelType(type, [&]<class T>(std::type_identity<T>) -> double {
    if constexpr (sizeof(T) == 1) return 0;  // a half holds all 8-bit values
    return roundAll(std::span(reinterpret_cast<T*>(voxels.data()), voxels.size() / sizeof(T)));
  });
}

HalfSource::HalfSource(std::unique_ptr<VolumeSource> exact) : exact_(std::move(exact)), info_(exact_->info()) {
  if (sizeOf(info_.type) > 4 || info_.type == VoxelType::i32 || info_.type == VoxelType::u32) {
    throw Error(ErrorCode::kUsage, "--half: rounds volumes of 16-bit integers and of floats; this one has " +
                                       std::string(nameOf(info_.type)));
  }
  info_.format += ", rounded to half";
}

void HalfSource::read(const VoxelBox& box, std::span<std::byte> out) {
  exact_->read(box, out);
  const double error = roundToHalf(info_.type, out);
  const std::scoped_lock lock(mutex_);
  largest_error_ = std::max(largest_error_, error);
}

double HalfSource::largestError() const {
  const std::scoped_lock lock(mutex_);
  return largest_error_;
}

}  // namespace kiln
