#include "engine/pixel/voxels/load_patch.h"

#include <algorithm>
#include <array>
#include <limits>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "engine/pixel/voxels/load_patch.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef KILN_UNIT_LOAD_ROWS
#define KILN_UNIT_LOAD_ROWS
namespace kiln {
namespace {

// Offsets of voxel rows: row (j, k) begins at data + y[j] + z[k] + x[0].
struct UnitRows {
  static constexpr int kEdge = kPatchEdge;
  std::array<std::int64_t, kPatchStride> x;
  std::array<std::int64_t, kEdge> y, z;
  int rim;  // outer voxels that only gradients read
  bool inner(int j, int k) const { return j >= rim && j < kEdge - rim && k >= rim && k < kEdge - rim; }

  // Combines the ranges of the columns.
  template <class T>
  SampledRange rangeOf(const T* least, const T* most, const bool* gaps, double offset) const {
    const int end = kEdge - rim;
    const T lo = *std::min_element(least + rim, least + end), hi = *std::max_element(most + rim, most + end);
    SampledRange out;
    if (lo <= hi) out.values.include({static_cast<double>(lo) + offset, static_cast<double>(hi) + offset});
    out.gaps = gaps != nullptr && std::any_of(gaps + rim, gaps + end, [](bool gap) { return gap; });
    return out;
  }
};

}  // namespace
}  // namespace kiln
#endif

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;

// Loads rows in whole vectors, for types of at most 16 bits, and their range column by column. requires: kPatchStride
// voxels from the start of each row are readable.
template <class T>
SampledRange loadVectors(const UnitRows& rows, const T* data, int offset, float* values) {
  const hn::CappedTag<std::int32_t, kPatchStride> di;
  const hn::RebindToFloat<decltype(di)> d;
  const hn::Rebind<T, decltype(di)> dt;
  const auto shift = hn::Set(di, offset);
  alignas(64) std::int32_t least[kPatchStride], most[kPatchStride];
  for (std::size_t x = 0; x < static_cast<std::size_t>(UnitRows::kEdge); x += hn::Lanes(di)) {
    auto lo = hn::Set(di, std::numeric_limits<std::int32_t>::max());
    auto hi = hn::Set(di, std::numeric_limits<std::int32_t>::lowest());
    float* to = values + x;
    for (int k = 0; k < UnitRows::kEdge; ++k) {
      const T* const plane = data + rows.z[static_cast<std::size_t>(k)] + rows.x[0] + x;
      for (int j = 0; j < UnitRows::kEdge; ++j, to += kPatchStride) {
        const auto v = hn::PromoteTo(di, hn::LoadU(dt, plane + rows.y[static_cast<std::size_t>(j)]));
        hn::Store(hn::ConvertTo(d, hn::Sub(v, shift)), d, to);
        if (!rows.inner(j, k)) continue;
        lo = hn::Min(lo, v);
        hi = hn::Max(hi, v);
      }
    }
    hn::Store(lo, di, least + x);
    hn::Store(hi, di, most + x);
  }
  return rows.rangeOf(least, most, nullptr, 0);
}

SampledRange loadU8(const UnitRows& rows, const std::uint8_t* data, int offset, float* values) {
  return loadVectors(rows, data, offset, values);
}
SampledRange loadI8(const UnitRows& rows, const std::int8_t* data, int offset, float* values) {
  return loadVectors(rows, data, offset, values);
}
SampledRange loadU16(const UnitRows& rows, const std::uint16_t* data, int offset, float* values) {
  return loadVectors(rows, data, offset, values);
}
SampledRange loadI16(const UnitRows& rows, const std::int16_t* data, int offset, float* values) {
  return loadVectors(rows, data, offset, values);
}

const char* targetName() { return hwy::TargetName(HWY_TARGET); }

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kiln {

HWY_EXPORT(loadU8);
HWY_EXPORT(loadI8);
HWY_EXPORT(loadU16);
HWY_EXPORT(loadI16);
HWY_EXPORT(targetName);

const char* instructionSet() { return HWY_DYNAMIC_DISPATCH(targetName)(); }

namespace {

SampledRange loadWhole(const UnitRows& rows, const std::uint8_t* data, int offset, float* values) {
  return HWY_DYNAMIC_DISPATCH(loadU8)(rows, data, offset, values);
}
SampledRange loadWhole(const UnitRows& rows, const std::int8_t* data, int offset, float* values) {
  return HWY_DYNAMIC_DISPATCH(loadI8)(rows, data, offset, values);
}
SampledRange loadWhole(const UnitRows& rows, const std::uint16_t* data, int offset, float* values) {
  return HWY_DYNAMIC_DISPATCH(loadU16)(rows, data, offset, values);
}
SampledRange loadWhole(const UnitRows& rows, const std::int16_t* data, int offset, float* values) {
  return HWY_DYNAMIC_DISPATCH(loadI16)(rows, data, offset, values);
}

// Clamps infinities and values near the limit of a float: no value can be interpolated between infinities.
double withinFloats(double value) {
  constexpr double kMost = 1e37;
  return value > kMost ? kMost : value < -kMost ? -kMost : value;
}

// Loads voxel by voxel: any type, and at the brick's ends.
template <class T>
SampledRange loadVoxels(const UnitRows& rows, const T* data, double offset, float* values) {
  std::array<float, kPatchStride> least, most;
  std::array<bool, kPatchStride> gaps{};
  least.fill(std::numeric_limits<float>::max()), most.fill(std::numeric_limits<float>::lowest());
  for (int k = 0; k < UnitRows::kEdge; ++k) {
    for (int j = 0; j < UnitRows::kEdge; ++j, values += kPatchStride) {
      const T* const from = data + rows.z[static_cast<std::size_t>(k)] + rows.y[static_cast<std::size_t>(j)];
      for (int i = 0; i < UnitRows::kEdge; ++i) {
        const double value = static_cast<double>(from[rows.x[static_cast<std::size_t>(i)]]) - offset;
        values[i] = static_cast<float>(std::is_floating_point_v<T> ? withinFloats(value) : value);
      }
      if (!rows.inner(j, k)) continue;
      for (int i = 0; i < UnitRows::kEdge; ++i) {
        const auto column = static_cast<std::size_t>(i);
        least[column] = values[i] < least[column] ? values[i] : least[column];
        most[column] = values[i] > most[column] ? values[i] : most[column];
        gaps[column] = gaps[column] || values[i] != values[i];
      }
    }
  }
  return rows.rangeOf(least.data(), most.data(), gaps.data(), offset);
}

}  // namespace

void voxelOffsets(const BrickBlock& block, int axis, std::int64_t first, int count, std::int64_t* out) {
  const std::int64_t extent = block.extent.extent()[axis], from = first - block.extent.lo[axis];
  const std::int64_t stride = axis == 0 ? 1 : axis == 1 ? block.strideY() : block.strideZ();
  if (from >= 0 && from + count <= extent) {
    for (int i = 0; i < count; ++i) out[i] = (from + i) * stride;
  } else {
    for (int i = 0; i < count; ++i) out[i] = std::clamp<std::int64_t>(from + i, 0, extent - 1) * stride;
  }
}

SampledRange loadPatch(const BrickBlock& block, const SampleLattice& lattice, double offset, const VoxelCoord& lo,
                       float* values) {
  UnitRows rows;
  // Linear interpolation reads the outermost voxels only for gradients.
  rows.rim = lattice.interpolation == Interpolation::kLinear ? 1 : 0;
  voxelOffsets(block, 0, lo.x - kPatchMargin, kPatchEdge, rows.x.data());
  voxelOffsets(block, 1, lo.y - kPatchMargin, kPatchEdge, rows.y.data());
  voxelOffsets(block, 2, lo.z - kPatchMargin, kPatchEdge, rows.z.data());
  const std::int64_t last_x = rows.x[static_cast<std::size_t>(UnitRows::kEdge) - 1];
  const std::int64_t last_row = rows.x[0] + rows.y[static_cast<std::size_t>(UnitRows::kEdge) - 1] +
                                rows.z[static_cast<std::size_t>(UnitRows::kEdge) - 1];
  return withVoxelType(block.type, [&]<class T>(std::type_identity<T>) {
    const T* const data = block.data<T>();
    if constexpr (sizeof(T) <= 2) {
      if (last_x - rows.x[0] == UnitRows::kEdge - 1 && last_row + kPatchStride <= block.extent.count())
        return loadWhole(rows, data, static_cast<int>(offset), values);
    }
    return loadVoxels(rows, data, offset, values);
  });
}

}  // namespace kiln
#endif
