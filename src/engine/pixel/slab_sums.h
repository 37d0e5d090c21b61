// Sums over the samples of several volumes, slab by slab, for one square of the picture. Extinctions add, and colours
// mix by optical depth, as in a mixture of participating media. A pixel has at most one sample per volume in a slab.
// Source: Max, Optical Models for Direct Volume Rendering, 1995, §5.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "engine/shared/slab_grid.h"
#include "engine/shared/tile_pixels.h"
#include "image/pixel_rect.h"

namespace kiln {

class SlabSums {
 public:
  /// Upper bound of a square's memory. unit: bytes.
  static constexpr std::uint64_t bytesFor(bool layers) {
    return std::uint64_t{kMostSharedSlabs} * sizeof(float) * (kSlabFloats + (layers ? kSlabLayerFloats : 0));
  }

  /// Clears the sums for the pixels of `rect` and for `slabs` slabs. requires: the rectangle is at most kSquareEdge
  /// wide and high; slabs <= kMostSharedSlabs.
  void reset(const PixelRect& rect, int slabs, bool layers) {
    rect_ = rect;
    slabs_ = slabs;
    rows_.fill(0);
    makeRoom(static_cast<std::size_t>(slabs) * kSlabFloats, light_);
    if (layers) makeRoom(static_cast<std::size_t>(slabs) * kSlabLayerFloats, layer_);
    has_layers_ = layers;
  }
  const PixelRect& rect() const { return rect_; }
  int slabs() const { return slabs_; }
  bool hasLayers() const { return has_layers_; }

  /// Light of a pixel in a slab. shape: RGB times optical depth, optical depth. requires: (x, y) in rect().
  float* light(int slab, int x, int y) { return &light_[kPixelFloats * placeToAdd(slab, x, y)]; }
  /// Adds a sample's mean normal in view space, no longer than 1, and its middle and thickness in slabs, weighted by
  /// its optical depth. requires: hasLayers().
  void addLayer(int slab, int x, int y, float depth, const glm::vec3& normal, float middle, float thickness) {
    float* const to = &layer_[kLayerFloats * placeToAdd(slab, x, y)];
    for (int axis = 0; axis < 3; ++axis) to[axis] += depth * normal[axis];
    to[3] += depth * middle;
    to[4] += depth * thickness;
  }

  static constexpr int kParts = 4;  // of a slab, for addShade
  /// Adds a sample's optical depth for a shadow map, which needs crossings of several surfaces in a slab apart. `place`
  /// of a crossing: in [0, 1] of the slab; nothing for a sample of a medium, which fills the slab. requires:
  /// hasLayers(); no addLayer.
  void addShade(int slab, int x, int y, float depth, std::optional<float> place) {
    float* const to = &layer_[kLayerFloats * placeToAdd(slab, x, y)];
    if (!place) {
      for (int part = 0; part < kParts; ++part) to[part] += depth / kParts;
      return;
    }
    to[std::clamp(static_cast<int>(*place * kParts), 0, kParts - 1)] += depth;
    to[kParts] += depth;
  }

  /// Returns true if a row of a slab has samples. Row 0 is the rectangle's first row.
  bool has(int slab, int row) const { return (rows_[static_cast<std::size_t>(slab)] >> row & 1) != 0; }
  /// Sums of a row that has samples. shape: 4 floats per pixel, kSquareEdge pixels, zero beyond the rectangle.
  const float* lightRow(int slab, int row) const { return &light_[kPixelFloats * rowPlace(slab, row)]; }
  /// Sums of a pixel's layer. shape: normal, middle, thickness; after addShade the depths of the slab's parts, and the
  /// depth of all crossings.
  const float* layer(int slab, int row, int column) const {
    return &layer_[kLayerFloats * (rowPlace(slab, row) + static_cast<std::size_t>(column))];
  }

  std::uint64_t bytes() const { return (light_.capacity() + layer_.capacity()) * sizeof(float); }

 private:
  static constexpr std::size_t kPixelFloats = 4, kLayerFloats = 5, kRow = kSquareEdge, kSlab = kRow * kSquareEdge;
  static_assert(kParts + 1 <= kLayerFloats, "a layer or a shade");
  static constexpr std::size_t kSlabFloats = kPixelFloats * kSlab, kSlabLayerFloats = kLayerFloats * kSlab;
  static_assert(kSquareEdge <= 64, "a slab has a bit a row");

  // Reserves exactly the charged memory; growing a vector could double its size.
  static void makeRoom(std::size_t floats, std::vector<float>& out) {
    if (out.size() >= floats) return;
    out.reserve(floats);
    out.resize(floats);
  }
  static std::size_t rowPlace(int slab, int row) {
    return static_cast<std::size_t>(slab) * kSlab + static_cast<std::size_t>(row) * kRow;
  }
  // Rows are cleared on their first sample, since most slabs of a square have few rows with samples.
  std::size_t placeToAdd(int slab, int x, int y) {
    const int row = y - rect_.y0;
    const std::uint64_t bit = std::uint64_t{1} << row;
    std::uint64_t& rows = rows_[static_cast<std::size_t>(slab)];
    const std::size_t place = rowPlace(slab, row);
    if ((rows & bit) == 0) {
      rows |= bit;
      std::fill_n(&light_[kPixelFloats * place], kPixelFloats * kRow, 0.0f);
      if (has_layers_) std::fill_n(&layer_[kLayerFloats * place], kLayerFloats * kRow, 0.0f);
    }
    return place + static_cast<std::size_t>(x - rect_.x0);
  }

  PixelRect rect_;
  int slabs_ = 0;
  bool has_layers_ = false;
  std::array<std::uint64_t, kMostSharedSlabs> rows_{};  // one bit per row: the row has samples
  std::vector<float> light_, layer_;
};

}  // namespace kiln
