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

  /// Adds an optical depth to the cell of pixel (x, y) at a depth of the view; ignores depths outside. thread: one
  /// thread at a time for each pixel.
  void add(int x, int y, double depth, float optical_depth) {
    const double at = std::floor((depth - near_) * view_.focal_px);
    if (!(at >= 0 && at < depth_)) return;
    std::uint16_t& open = cells_[placeOf(x, y, static_cast<int>(at))];
    open = static_cast<std::uint16_t>(std::lround((kClear - open) * std::exp(-optical_depth)));
    open = static_cast<std::uint16_t>(kClear - open);
  }
  /// Keeps the larger opacity of each cell and of the cell that is the same place in a lattice turned once or twice
  /// (turned): cell (x, y, z) is (y, z, x) there, or (z, x, y).
  void keepLarger(const ExtinctionLattice& other, int turns) {
    for (int z = 0; z < depth_; ++z) {
      for (int y = 0; y < view_.size.height; ++y) {
        for (int x = 0; x < view_.size.width; ++x) {
          std::uint16_t& here = cells_[placeOf(x, y, z)];
          here = std::max(here, other.cells_[turns == 1 ? other.placeOf(y, z, x) : other.placeOf(z, x, y)]);
        }
      }
    }
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
  std::vector<std::uint16_t> cells_;  // opacities
};

}  // namespace kiln
