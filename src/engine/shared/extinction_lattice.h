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

#include "grid/coords.h"
#include "scene/camera/camera.h"

namespace kiln {

/// A parallel view of a lattice: view.size pixels times `depth` cells, cubes of a pixel's edge; cell 0 begins at depth
/// `near`. unit: near: world.
struct LatticeView {
  View view;
  double near = 0;
  int depth = 1;
  Extent3 cells() const { return {view.size.width, view.size.height, depth}; }
};
/// Returns the view of equal cells along another axis: axes x, y, z of the returned view are axes y, z, x of the given.
LatticeView turned(const LatticeView& lattice);

class ExtinctionLattice {
 public:
  explicit ExtinctionLattice(const LatticeView& lattice)
      : lattice_(lattice), cells_(static_cast<std::size_t>(lattice.cells().count())) {}

  const LatticeView& lattice() const { return lattice_; }
  /// Edge of a cell. unit: world.
  double edge() const { return 1 / lattice_.view.focal_px; }

  /// Takes the optical depths of the view that is turned once more, from now on. A cell keeps the largest of the
  /// opacities along all axes.
  void turn() { ++turns_; }

  /// Adds an optical depth to the cell of pixel (x, y) at a depth of the drawn view; ignores depths outside. thread:
  /// one thread at a time for each pixel.
  void add(int x, int y, double depth, float optical_depth) {
    const double at = std::floor((depth - lattice_.near) * lattice_.view.focal_px);
    const ImageSize& size = lattice_.view.size;
    const int cells[3] = {lattice_.depth, size.width, size.height};  // along the drawn view's depth
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

  std::size_t placeOf(int x, int y, int z) const {
    const Extent3 n = lattice_.cells();
    return static_cast<std::size_t>((z * n.y + y) * n.x + x);
  }

  LatticeView lattice_;
  int turns_ = 0;
  std::vector<std::uint16_t> cells_;  // opacities
};

}  // namespace kiln
