// Sums over the samples of several volumes, slab by slab, for one square of the picture. Extinctions add, and colours
// mix by optical depth, as in a mixture of participating media. A pixel has at most one sample per volume in a slab.
// Source: Max, Optical Models for Direct Volume Rendering, 1995, §5.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "engine/shared/slab_grid.h"
#include "engine/shared/tile_pixels.h"
#include "image/pixel_rect.h"

namespace kiln {

class SlabSums {
 public:
  /// Upper bound of a square's memory. unit: bytes.
  static constexpr std::uint64_t bytesFor(bool normals) {
    return std::uint64_t{kMostSharedSlabs} * kSlabFloats * sizeof(float) * (normals ? 2 : 1);
  }

  /// Clears the sums for the pixels of `rect` and for `slabs` slabs. requires: the rectangle is at most kSquareEdge
  /// wide and high; slabs <= kMostSharedSlabs.
  void reset(const PixelRect& rect, int slabs, bool normals) {
    rect_ = rect;
    slabs_ = slabs;
    rows_.fill(0);
    const std::size_t floats = static_cast<std::size_t>(slabs) * kSlabFloats;
    makeRoom(floats, light_);
    if (normals) makeRoom(floats, normal_);
    has_normals_ = normals;
  }
  const PixelRect& rect() const { return rect_; }
  int slabs() const { return slabs_; }
  bool hasNormals() const { return has_normals_; }

  /// Light of a pixel in a slab. shape: RGB times optical depth, optical depth. requires: (x, y) in rect().
  float* light(int slab, int x, int y) { return &light_[placeToAdd(slab, x, y)]; }
  /// Adds a unit normal in view space times optical depth.
  void addNormal(int slab, int x, int y, const glm::vec3& normal) {
    float* const to = &normal_[placeToAdd(slab, x, y)];
    for (int axis = 0; axis < 3; ++axis) to[axis] += normal[axis];
  }

  /// Returns true if a row of a slab has samples. Row 0 is the rectangle's first row.
  bool has(int slab, int row) const { return (rows_[static_cast<std::size_t>(slab)] >> row & 1) != 0; }
  /// Sums of a row that has samples. shape: 4 floats per pixel, kSquareEdge pixels, zero beyond the rectangle.
  const float* lightRow(int slab, int row) const { return &light_[rowPlace(slab, row)]; }
  const float* normalRow(int slab, int row) const { return &normal_[rowPlace(slab, row)]; }

  std::uint64_t bytes() const { return (light_.capacity() + normal_.capacity()) * sizeof(float); }

 private:
  static constexpr std::size_t kRowFloats = std::size_t{4} * kSquareEdge, kSlabFloats = kRowFloats * kSquareEdge;
  static_assert(kSquareEdge <= 64, "a slab has a bit a row");

  // Reserves exactly the charged memory; growing a vector could double its size.
  static void makeRoom(std::size_t floats, std::vector<float>& out) {
    if (out.size() >= floats) return;
    out.reserve(floats);
    out.resize(floats);
  }
  static std::size_t rowPlace(int slab, int row) {
    return static_cast<std::size_t>(slab) * kSlabFloats + static_cast<std::size_t>(row) * kRowFloats;
  }
  // Rows are cleared on their first sample, since most slabs of a square have few rows with samples.
  std::size_t placeToAdd(int slab, int x, int y) {
    const int row = y - rect_.y0;
    const std::uint64_t bit = std::uint64_t{1} << row;
    std::uint64_t& rows = rows_[static_cast<std::size_t>(slab)];
    const std::size_t place = rowPlace(slab, row);
    if ((rows & bit) == 0) {
      rows |= bit;
      std::fill_n(&light_[place], kRowFloats, 0.0f);
      if (has_normals_) std::fill_n(&normal_[place], kRowFloats, 0.0f);
    }
    return place + static_cast<std::size_t>(4 * (x - rect_.x0));
  }

  PixelRect rect_;
  int slabs_ = 0;
  bool has_normals_ = false;
  std::array<std::uint64_t, kMostSharedSlabs> rows_{};  // one bit per row: the row has samples
  std::vector<float> light_, normal_;
};

}  // namespace kiln
