// Opacities of a lattice of cells, drawn as a picture is: the cells of a pixel lie behind each other.
// Problem. Ambient occlusion needs the extinction around any point, of all volumes, after classification and clipping.
// Method. An engine draws a parallel view with kRaysOfCell² rays through a cell; the opacity of a cell is the mean over
// the rays. One ray misses structures smaller than a cell, which shows as stripes. Zones of slabs divide cells: the
// optical depth of a ray's last cell is kept until the ray reaches the next cell.
// Invariant. A cell depends on its rays' slabs only, in any order of rays.
// Memory: three bytes a cell, eight a ray.
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

  explicit ExtinctionLattice(const LatticeView& lattice);
  /// unit: bytes.
  static std::uint64_t bytesOf(const LatticeView& lattice);

  const LatticeView& lattice() const { return lattice_; }
  /// Edge of a cell. unit: world.
  double edge() const { return kRaysOfCell / lattice_.view.focal_px; }

  /// Ends a view. The next view is turned once more. A cell keeps the largest of the opacities along all axes.
  void turn();

  /// Returns the place of a depth along the drawn view. unit: cells; depth: world.
  double placeAlong(double depth) const { return (depth - lattice_.near) * lattice_.view.focal_px / kRaysOfCell; }
  /// Adds the optical depth of the ray of pixel (x, y) in a cell along the drawn view; cells outside are left out.
  /// requires: the cells of a ray in their order along the view. thread: one thread at a time for each column of cells.
  void add(int x, int y, int cell, float optical_depth) {
    if (cell < 0 || cell >= drawn_.cells().z) return;
    LastCell& last = rays_[static_cast<std::size_t>(y * drawn_.view.size.width + x)];
    if (last.cell == cell) {
      last.optical_depth += optical_depth;
      return;
    }
    end(x, y, last);
    last = {cell, optical_depth};
  }
  /// Transmittances of paths as long as the edge of a cell, of all views that have ended. unit: 1 / 255. shape:
  /// lattice().cells().
  const Cells<std::uint8_t>& transmittances() const { return open_; }

 private:
  static constexpr std::uint16_t kClosed = std::numeric_limits<std::uint16_t>::max();

  /// The last cell that a ray has met.
  struct LastCell {
    int cell = -1;
    float optical_depth = 0;
  };

  // Adds the opacity of a ray's last cell.
  void end(int x, int y, const LastCell& last) {
    if (last.cell < 0) return;
    const int z = last.cell;
    x /= kRaysOfCell, y /= kRaysOfCell;
    std::uint16_t& cell = sums_[turns_ == 0 ? placeOf(x, y, z) : turns_ == 1 ? placeOf(z, x, y) : placeOf(y, z, x)];
    constexpr int kRays = kRaysOfCell * kRaysOfCell;
    const long closed = std::lround((1 - std::exp(-last.optical_depth)) * (float{kClosed} / kRays));
    cell = static_cast<std::uint16_t>(std::min<long>(cell + closed, kClosed));
  }

  std::size_t placeOf(int x, int y, int z) const {
    const Extent3 n = lattice_.cells();
    return static_cast<std::size_t>((z * n.y + y) * n.x + x);
  }

  const LatticeView lattice_;
  LatticeView drawn_;  // the lattice after `turns_` turns
  int turns_ = 0;
  std::vector<LastCell> rays_;  // of the drawn view
  Cells<std::uint16_t> sums_;   // opacities, of the drawn view
  Cells<std::uint8_t> open_;
};

}  // namespace kiln
