// Finds the spaces between voxels of a cell in which samples may be visible. A sample is interpolated from the eight
// voxels around it. The sample is invisible if no such voxel is above the least visible value, or no such voxel is
// below the greatest. Compiled once for each instruction set; hence no #pragma once.
#if defined(KILN_SPLAT_SHOWN_SPACES_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef KILN_SPLAT_SHOWN_SPACES_INL_H
#undef KILN_SPLAT_SHOWN_SPACES_INL_H
#else
#define KILN_SPLAT_SHOWN_SPACES_INL_H
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
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

// One bit per voxel around the spaces: bit x of row y of plane z.
constexpr int kSpaceRows = kSpaces + 2;
struct VoxelBits {
  static constexpr std::size_t kBytes = 16;  // rows of a plane, padded
  std::uint16_t rows[kSpaceRows][kBytes] = {};
};
// Offset of a row of voxels. shape: as loadPatch's `values`.
constexpr std::ptrdiff_t rowOfVoxels(int y, int z) {
  constexpr int kFirst = kPatchMargin - 1, kEdge = kPatchEdge;
  return ((z + kFirst) * kEdge + y + kFirst) * kPatchStride + kFirst;
}

// Returns the spaces with a set voxel at a corner: combines neighbours along x, then y, then z.
HWY_INLINE Spaces spacesAround(const VoxelBits& voxels) {
  std::uint64_t planes[kSpaceRows];
  for (int z = 0; z < kSpaceRows; ++z) {
    std::uint8_t rows[VoxelBits::kBytes];
    for (std::size_t y = 0; y < VoxelBits::kBytes; ++y) {
      const unsigned row = voxels.rows[z][y];
      rows[y] = static_cast<std::uint8_t>((row | row >> 1) | (row >> 2 & 0x80));
    }
    std::uint64_t before, after;
    std::memcpy(&before, rows, sizeof before);
    std::memcpy(&after, rows + 1, sizeof after);
    planes[z] = before | after | std::uint64_t{rows[kSpaceRows - 1]} << 56;
  }
  Spaces out;
  for (std::size_t z = 0; z < kSpaces; ++z)
    out[z] = planes[z] | planes[z + 1] | planes[z + 1 < kSpaces ? z + 1 : kSpaceRows - 1];
  return out;
}

// Returns the spaces in which samples may be visible. shape: `values` as loadPatch's.
HWY_INLINE Spaces visibleSpaces(const SampleLattice& l, const float* values) {
  const D d;
  constexpr float kFar = std::numeric_limits<float>::infinity();
  // For each row of voxels: masks of the voxels above the least visible position and below the greatest. Values beyond
  // the table's ends are clamped to it.
  const V scale = hn::Set(d, l.table_scale);
  const V begin = hn::Set(d, l.visible_after < 0 ? -kFar : l.visible_after);
  const V end = hn::Set(d, l.visible_before > l.table_last ? kFar : l.visible_before);
  VoxelBits above, below;
  for (int z = 0; z < kSpaceRows; ++z) {
    for (int y = 0; y < kSpaceRows; ++y) {
      const float* const row = values + rowOfVoxels(y, z);
      std::uint8_t bits[2][8] = {};
      for (std::size_t x = 0; x < kPatchStride; x += hn::Lanes(d)) {
        const V place = hn::Mul(hn::LoadU(d, row + x), scale);
        addBits(hn::Gt(place, begin), x, bits[0]);
        addBits(hn::Lt(place, end), x, bits[1]);
      }
      std::memcpy(&above.rows[z][y], bits[0], 2);
      std::memcpy(&below.rows[z][y], bits[1], 2);
    }
  }
  Spaces out = spacesAround(above);
  const Spaces also = spacesAround(below);
  for (std::size_t z = 0; z < kSpaces; ++z) out[z] &= also[z];
  return out;
}

// Returns the spaces with voxels on both sides of a surface at their corners. shape: `values` as loadPatch's.
HWY_INLINE Spaces crossedSpaces(const SampleLattice& l, const float* values) {
  const D d;
  Spaces out{};
  for (int surface = 0; surface < l.surfaces; ++surface) {
    const V least = hn::Set(d, l.surface_values[surface]);
    VoxelBits inside, outside;
    for (int z = 0; z < kSpaceRows; ++z) {
      for (int y = 0; y < kSpaceRows; ++y) {
        const float* const row = values + rowOfVoxels(y, z);
        std::uint8_t bits[2][8] = {};
        for (std::size_t x = 0; x < kPatchStride; x += hn::Lanes(d)) {
          const V value = hn::LoadU(d, row + x);
          addBits(hn::Ge(value, least), x, bits[0]);
          addBits(hn::Lt(value, least), x, bits[1]);
        }
        std::memcpy(&inside.rows[z][y], bits[0], 2);
        std::memcpy(&outside.rows[z][y], bits[1], 2);
      }
    }
    const Spaces of_inside = spacesAround(inside), of_outside = spacesAround(outside);
    for (std::size_t z = 0; z < kSpaces; ++z) out[z] |= of_inside[z] & of_outside[z];
  }
  return out;
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

// Returns the spaces next to a voxel of a visible label (LabelVoxels::ranks).
HWY_INLINE Spaces labelledSpaces(const std::int32_t* ranks) {
  const DI di;
  VoxelBits shown;
  for (int z = 0; z < kSpaceRows; ++z) {
    for (int y = 0; y < kSpaceRows; ++y) {
      const std::int32_t* const row = ranks + rowOfVoxels(y, z);
      std::uint8_t bits[8] = {};
      for (std::size_t x = 0; x < kPatchStride; x += hn::Lanes(di))
        addBits(hn::RebindMask(D(), hn::Gt(hn::LoadU(di, row + x), hn::Set(di, -1))), x, bits);
      std::memcpy(&shown.rows[z][y], bits, 2);
    }
  }
  return spacesAround(shown);
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
