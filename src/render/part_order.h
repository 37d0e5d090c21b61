// How partial images are put together (DESIGN §8): which is before which, and one pixel over another.
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "base/edge_layers.h"
#include "grid/coords.h"
#include "grid/geometry.h"
#include "output/image.h"
#include "scene/camera.h"

namespace kiln {

/// The parts' places in `boxes`, front to back: one is before another where a ray could pass it first. Nothing where
/// some hide one another in turn. requires: boxes of voxels of the volume, without a common voxel.
std::optional<std::vector<int>> frontToBack(std::span<const VoxelBox> boxes, const View& view,
                                            const VolumeGeometry& volume);

/// Light, alpha, and what slabs cover of the pixel's area (splat/coverage.h).
struct PartPixel {
  float rgba[4] = {}, covered = 0;
};

/// Puts `behind` behind `front`, as slabs are laid behind each other. A pixel that reaches the threshold is divided by
/// its alpha and closed, as when it is drawn.
inline void layBehind(const EdgeLayer& behind, float opaque_at, PartPixel& front) {
  if (front.rgba[3] == 1.0f) return;
  layBehind(behind, front.rgba, front.covered);
  if (front.rgba[3] < opaque_at) return;
  for (int c = 0; c < 3; ++c) front.rgba[c] /= front.rgba[3];
  front.rgba[3] = 1.0f;
}

/// All that a part shows in a pixel, as if it were one slab: exact where that part's first slab covers all of the
/// pixel. requires: it covers something.
inline EdgeLayer asLayer(const PartPixel& pixel) {
  EdgeLayer out{pixel.covered, {}};
  for (std::size_t c = 0; c < 4; ++c) out.rgba[c] = pixel.rgba[c] / pixel.covered;
  return out;
}

/// Of a part's image, which has the plane of what is covered.
inline PartPixel pixelOf(const Image& part, int x, int y) {
  PartPixel out;
  std::copy_n(part.pixel(x, y), 4, out.rgba);
  out.covered =
      part.planes.front()
          .values[static_cast<std::size_t>(y) * static_cast<std::size_t>(part.width) + static_cast<std::size_t>(x)];
  return out;
}

/// The picture that composited pixels are. shape: rows of `width`.
Image colorsOf(std::span<const PartPixel> pixels, int width);

/// How many layers a part's pixel has: of its edges, else one, or none where it is empty.
inline int layersOf(const Image& part, int x, int y) {
  const EdgeLayers* const edges = part.edges.get();
  const int listed = edges == nullptr ? 0 : edges->count(edges->rect().x0 + x, edges->rect().y0 + y);
  return listed > 0 ? listed : pixelOf(part, x, y).covered > 0 ? 1 : 0;
}

/// Calls f(layer) for them, from front to back.
template <class F>
void forEachLayer(const Image& part, int x, int y, const F& f) {
  const EdgeLayers* const edges = part.edges.get();
  if (edges != nullptr && edges->count(edges->rect().x0 + x, edges->rect().y0 + y) > 0) {
    edges->forEach(edges->rect().x0 + x, edges->rect().y0 + y, f);
  } else if (const PartPixel pixel = pixelOf(part, x, y); pixel.covered > 0) {
    f(asLayer(pixel));
  }
}

}  // namespace kiln
