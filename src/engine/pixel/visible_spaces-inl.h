// Finds the spaces between voxels of a cell in which samples may be visible. A sample is interpolated from the eight
// voxels around it, a cubic from 64, and lies between the least and the greatest. The sample is invisible if no such
// voxel is above the least visible value, or no such voxel is below the greatest. kReach: voxels beyond the nearest
// that a sample is interpolated from along each axis; 0 linear, 1 cubic. Compiled once for each instruction set; hence
// no #pragma once.
#if defined(KILN_VISIBLE_SPACES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_VISIBLE_SPACES_INL_H
#undef KILN_VISIBLE_SPACES_INL_H
#else
#define KILN_VISIBLE_SPACES_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>

#include "engine/pixel/voxels/load_patch.h"
#include "engine/pixel/voxels/sample_lattice.h"
#include "engine/shared/sample_math-inl.h"

HWY_BEFORE_NAMESPACE();
namespace kiln {
namespace HWY_NAMESPACE {
namespace {

// One bit per space between two voxels along each axis, from the voxel before a cell on: bit x of byte y of word z.
// There are nine spaces per axis; the last two share a bit, so that eight planes form a vector.
constexpr int kSpaces = kPatchVoxels;
using Spaces = std::array<std::uint64_t, kSpaces>;

// Stores the mask at bit x of sixteen.
HWY_INLINE void addBits(M mask, std::size_t x, std::uint8_t* to) {
  std::uint8_t bits[8] = {};
  hn::StoreMaskBits(D(), mask, bits);
  if constexpr (hn::MaxLanes(D()) >= 8) {
    to[x / 8] = bits[0], to[x / 8 + 1] |= bits[1];
  } else {
    to[x / 8] = static_cast<std::uint8_t>(to[x / 8] | bits[0] << x % 8);
  }
}

// One bit per voxel from which the spaces are interpolated: bit x of row y of plane z.
template <int kReach>
struct VoxelBits {
  static constexpr int kRows = kSpaces + 2 + 2 * kReach;
  static constexpr std::size_t kBytes = 16;  // rows of a plane, padded
  static_assert(kReach < kPatchMargin && kRows <= kPatchStride);
  std::uint16_t rows[kRows][kBytes] = {};

  // Offset of a row of voxels. shape: as loadPatch's `values`.
  static constexpr std::ptrdiff_t offsetOf(int y, int z) {
    constexpr int kFirst = kPatchMargin - 1 - kReach;
    return ((z + kFirst) * kPatchEdge + y + kFirst) * kPatchStride + kFirst;
  }
};

// Calls f(y, z, row) for the rows of the voxels from which the spaces are interpolated.
template <int kReach, class T, class F>
HWY_INLINE void forEachRow(const T* voxels, F f) {
  using Bits = VoxelBits<kReach>;
  for (int z = 0; z < Bits::kRows; ++z) {
    for (int y = 0; y < Bits::kRows; ++y) f(y, z, voxels + Bits::offsetOf(y, z));
  }
}

// Returns the masks of a row's vectors: mask(x) for the voxels from the x-th on.
template <class F>
HWY_INLINE std::uint16_t bitsOf(F mask) {
  std::uint8_t bits[8] = {};
  for (std::size_t x = 0; x < kPatchStride; x += hn::Lanes(D())) addBits(mask(x), x, bits);
  std::uint16_t out;
  std::memcpy(&out, bits, sizeof out);
  return out;
}

// Returns the spaces that a set voxel takes part in: combines neighbours along x, then y, then z.
template <int kReach>
HWY_INLINE Spaces spacesAround(const VoxelBits<kReach>& voxels) {
  using Bits = VoxelBits<kReach>;
  constexpr int kWidth = 2 + 2 * kReach;
  std::uint64_t planes[Bits::kRows];
  for (int z = 0; z < Bits::kRows; ++z) {
    std::uint8_t rows[Bits::kBytes];
    for (std::size_t y = 0; y < Bits::kBytes; ++y) {
      unsigned row = voxels.rows[z][y];
      row |= row >> 1;
      if constexpr (kReach > 0) row |= row >> 2;
      rows[y] = static_cast<std::uint8_t>(row | (row >> 1 & 0x80));
    }
    planes[z] = 0;
    for (int i = 0; i <= kWidth; ++i) {
      std::uint64_t plane;
      std::memcpy(&plane, rows + i, sizeof plane);
      planes[z] |= i < kWidth ? plane : plane & std::uint64_t{0xff} << 56;
    }
  }
  Spaces out;
  for (std::size_t z = 0; z < kSpaces; ++z) {
    out[z] = 0;
    for (std::size_t i = 0; i < kWidth; ++i) out[z] |= planes[z + i];
    if (z + 1 == kSpaces) out[z] |= planes[z + kWidth];
  }
  return out;
}

// Returns the spaces in which samples may be visible. shape: `values` as loadPatch's.
template <int kReach>
HWY_INLINE Spaces visibleSpaces(const SampleLattice& l, const float* values) {
  const D d;
  constexpr float kFar = std::numeric_limits<float>::infinity();
  // For each row of voxels: masks of the voxels above the least visible position and below the greatest. Values beyond
  // the table's ends are clamped to it, infinite values, too.
  const V scale = hn::Set(d, l.table_scale);
  const V first = hn::Set(d, l.visible_after < 0 ? -kFar : std::nextafter(l.visible_after, kFar));
  const V last = hn::Set(d, l.visible_before > l.table_last ? kFar : std::nextafter(l.visible_before, -kFar));
  VoxelBits<kReach> above, below;
  forEachRow<kReach>(values, [&](int y, int z, const float* row) {
    const auto place = [&](std::size_t x) { return hn::Mul(hn::LoadU(d, row + x), scale); };
    above.rows[z][y] = bitsOf([&](std::size_t x) { return hn::Ge(place(x), first); });
    below.rows[z][y] = bitsOf([&](std::size_t x) { return hn::Le(place(x), last); });
  });
  Spaces out = spacesAround(above);
  const Spaces also = spacesAround(below);
  for (std::size_t z = 0; z < kSpaces; ++z) out[z] &= also[z];
  return out;
}

// Returns the spaces that are interpolated from voxels on both sides of a surface. shape: `values` as loadPatch's.
template <int kReach>
HWY_INLINE Spaces crossedSpaces(const SampleLattice& l, const float* values) {
  const D d;
  Spaces out{};
  for (int surface = 0; surface < l.surfaces; ++surface) {
    const V least = hn::Set(d, l.surface_values[surface]);
    VoxelBits<kReach> inside, outside;
    forEachRow<kReach>(values, [&](int y, int z, const float* row) {
      inside.rows[z][y] = bitsOf([&](std::size_t x) { return hn::Ge(hn::LoadU(d, row + x), least); });
      outside.rows[z][y] = bitsOf([&](std::size_t x) { return hn::Lt(hn::LoadU(d, row + x), least); });
    });
    const Spaces of_inside = spacesAround(inside), of_outside = spacesAround(outside);
    for (std::size_t z = 0; z < kSpaces; ++z) out[z] |= of_inside[z] & of_outside[z];
  }
  return out;
}

// Returns the spaces that are interpolated from a voxel of a visible label (LabelVoxels::ranks).
template <int kReach>
HWY_INLINE Spaces labelledSpaces(const std::int32_t* ranks) {
  const DI di;
  VoxelBits<kReach> shown;
  forEachRow<kReach>(ranks, [&](int y, int z, const std::int32_t* row) {
    shown.rows[z][y] =
        bitsOf([&](std::size_t x) { return hn::RebindMask(D(), hn::Gt(hn::LoadU(di, row + x), hn::Set(di, -1))); });
  });
  return spacesAround(shown);
}

// Returns the spaces of which a set space is among the eight from the space itself to the next along each axis.
inline Spaces spacesBefore(const Spaces& spaces) {
  Spaces out;
  for (std::size_t z = 0; z < kSpaces; ++z) {
    const std::uint64_t plane = spaces[z] | (z + 1 < kSpaces ? spaces[z + 1] : 0), rows = plane | plane >> 8;
    out[z] = rows | (rows >> 1 & 0x7f7f7f7f7f7f7f7f);
  }
  return out;
}

// Returns the spaces that are set, or next to a set space along any axes.
inline Spaces grown(const Spaces& spaces) {
  constexpr std::uint64_t kNotFirst = 0xfefefefefefefefe, kNotLast = 0x7f7f7f7f7f7f7f7f;
  Spaces out;
  for (std::size_t z = 0; z < kSpaces; ++z) {
    const std::uint64_t plane = spaces[z] | (z > 0 ? spaces[z - 1] : 0) | (z + 1 < kSpaces ? spaces[z + 1] : 0);
    const std::uint64_t rows = plane | plane << 8 | plane >> 8;
    out[z] = rows | (rows << 1 & kNotFirst) | (rows >> 1 & kNotLast);
  }
  return out;
}

// Bounding box of the set spaces; boxOf returns false if there are none.
struct SpaceBox {
  int first[3], last[3];
};
inline bool boxOf(const Spaces& spaces, SpaceBox& out) {
  std::uint64_t rows = 0;
  out.first[2] = kSpaces;
  for (int z = 0; z < kSpaces; ++z) {
    const std::uint64_t plane = spaces[static_cast<std::size_t>(z)];
    rows |= plane;
    if (plane != 0) out.first[2] = std::min(out.first[2], z), out.last[2] = z;
  }
  if (rows == 0) return false;
  out.first[1] = std::countr_zero(rows) / kSpaces, out.last[1] = (63 - std::countl_zero(rows)) / kSpaces;
  for (int shift = 32; shift >= kSpaces; shift /= 2) rows |= rows >> shift;
  const auto columns = static_cast<std::uint8_t>(rows);
  out.first[0] = std::countr_zero(columns), out.last[0] = kSpaces - 1 - std::countl_zero(columns);
  return true;
}

}  // namespace
}  // namespace HWY_NAMESPACE
}  // namespace kiln
HWY_AFTER_NAMESPACE();

#endif
