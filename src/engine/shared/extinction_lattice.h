// Opacities of a lattice of cells, drawn as a picture is: the cells of a pixel lie behind each other.
// Problem. Ambient occlusion needs the extinction around any point, of all volumes, after classification and clipping.
// Method. An engine draws a parallel view with kRaysOfCell² rays through a cell; the opacity of a cell is the mean over
// the rays. One ray misses structures smaller than a cell, which shows as stripes.
// Invariant. A cell depends on its rays' slabs only, in any order of rays.
// Memory: three bytes a cell.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "base/memory/large_pages.h"
#include "grid/coords.h"
#include "scene/camera/camera.h"

namespace kiln {

/// Rays along an edge of a cell. Figures: frame/decisions/occlusion-cells.md.
inline constexpr int kRaysOfCell = 2;

/// A parallel view of a lattice: view.size rays, and `depth` times their distance from depth `near` on. unit: near:
/// world.
struct LatticeView {
  View view;
  double near = 0;
  int depth = 1;
  Extent3 cells() const {
    const auto count = [](int rays) { return (rays + kRaysOfCell - 1) / kRaysOfCell; };
    return {count(view.size.width), count(view.size.height), count(depth)};
  }
};
/// Returns the view of equal cells along another axis: axes x, y, z of the returned view are axes y, z, x of the given.
LatticeView turned(const LatticeView& lattice);

class ExtinctionLattice {
 public:
  // In large pages, because turned views and cones read cells far apart.
  template <class T>
  using Cells = std::vector<T, UnsetAllocator<T>>;

  explicit ExtinctionLattice(const LatticeView& lattice)
      : lattice_(lattice), sums_(static_cast<std::size_t>(lattice.cells().count()), 0) {}

  const LatticeView& lattice() const { return lattice_; }
  /// Edge of a cell. unit: world.
  double edge() const { return kRaysOfCell / lattice_.view.focal_px; }

  /// Ends a view. The next view is turned once more. A cell keeps the largest of the opacities along all axes.
  void turn();

  /// Returns the cell, along the drawn view, of a depth; -1 outside.
  int cellAt(double depth) const {
    const Extent3 n = lattice_.cells();
    const std::int64_t cells[3] = {n.z, n.x, n.y};
    const double at = std::floor((depth - lattice_.near) * lattice_.view.focal_px / kRaysOfCell);
    return at >= 0 && at < static_cast<double>(cells[turns_]) ? static_cast<int>(at) : -1;
  }
  /// Adds the optical depth of the ray of pixel (x, y) in a cell along the drawn view. thread: one thread at a time for
  /// each cell.
  void add(int x, int y, int z, float optical_depth) {
    x /= kRaysOfCell, y /= kRaysOfCell;
    std::uint16_t& cell = sums_[turns_ == 0 ? placeOf(x, y, z) : turns_ == 1 ? placeOf(z, x, y) : placeOf(y, z, x)];
    constexpr int kRays = kRaysOfCell * kRaysOfCell;
    const long closed = std::lround((1 - std::exp(-optical_depth)) * (float{kClosed} / kRays));
    cell = static_cast<std::uint16_t>(std::min<long>(cell + closed, kClosed));
  }
  /// Transmittances of paths as long as the edge of a cell, of all views that have ended. unit: 1 / 255. shape:
  /// lattice().cells().
  const Cells<std::uint8_t>& transmittances() const { return open_; }

 private:
  static constexpr std::uint16_t kClosed = std::numeric_limits<std::uint16_t>::max();

  std::size_t placeOf(int x, int y, int z) const {
    const Extent3 n = lattice_.cells();
    return static_cast<std::size_t>((z * n.y + y) * n.x + x);
  }

  LatticeView lattice_;
  int turns_ = 0;
  Cells<std::uint16_t> sums_;  // opacities, of the drawn view
  Cells<std::uint8_t> open_;
};

}  // namespace kiln
