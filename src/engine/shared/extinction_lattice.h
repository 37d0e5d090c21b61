// Opacities of a lattice of cells, drawn as a picture is: the cells of a pixel lie behind each other.
// Problem. Ambient occlusion needs the extinction around any point, of all volumes, after classification and clipping.
// Method. An engine draws a parallel view and adds the optical depth of each slab to the cell of the slab's middle.
// Invariant. A cell depends on its slabs in order of depth only.
// Memory: two bytes a cell.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "scene/camera/camera.h"

namespace kiln {

class ExtinctionLattice {
 public:
  /// A lattice of view.size pixels times `depth` cells, cubes of a pixel's edge; cell 0 begins at depth `near`.
  /// requires: a parallel view.
  ExtinctionLattice(const View& view, double near, int depth)
      : view_(view),
        near_(near),
        depth_(depth),
        cells_(static_cast<std::size_t>(view.size.width) * height() * deep()) {}

  const View& view() const { return view_; }
  double near() const { return near_; }
  int depth() const { return depth_; }
  /// Edge of a cell. unit: world.
  double edge() const { return 1 / view_.focal_px; }

  /// Draws the lattice along another of its axes from now on: axes x, y, z of the drawn view are y, z, x of the lattice
  /// after one turn, and z, x, y after two. A cell keeps the larger of the opacities along all axes.
  void turn() { ++turns_; }

  /// Adds an optical depth to the cell of pixel (x, y) at a depth of the drawn view; ignores depths outside. thread:
  /// one thread at a time for each pixel.
  void add(int x, int y, double depth, float optical_depth) {
    const double at = std::floor((depth - near_) * view_.focal_px);
    const int cells[3] = {depth_, view_.size.width, view_.size.height};  // along the drawn view's depth
    if (!(at >= 0 && at < cells[turns_])) return;
    const int z = static_cast<int>(at);
    std::uint16_t& cell = cells_[turns_ == 0 ? placeOf(x, y, z) : turns_ == 1 ? placeOf(z, x, y) : placeOf(y, z, x)];
    const int open = turns_ == 0 ? kClear - cell : kClear;
    const auto closed =
        static_cast<std::uint16_t>(kClear - std::lround(static_cast<float>(open) * std::exp(-optical_depth)));
    cell = std::max(cell, closed);
  }
  /// Transmittance of a path as long as the edge of a cell; 1 outside. requires: 0 <= x, y, z are cells.
  float transmittance(int x, int y, int z) const {
    return static_cast<float>(kClear - cells_[placeOf(x, y, z)]) * (1.0f / kClear);
  }

 private:
  static constexpr std::uint16_t kClear = std::numeric_limits<std::uint16_t>::max();

  std::size_t height() const { return static_cast<std::size_t>(view_.size.height); }
  std::size_t deep() const { return static_cast<std::size_t>(depth_); }
  std::size_t placeOf(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * height() + static_cast<std::size_t>(y)) *
               static_cast<std::size_t>(view_.size.width) +
           static_cast<std::size_t>(x);
  }

  View view_;
  double near_;
  int depth_;
  int turns_ = 0;
  std::vector<std::uint16_t> cells_;  // opacities
};

}  // namespace kiln
