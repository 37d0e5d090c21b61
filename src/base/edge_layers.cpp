#include "base/edge_layers.h"

#include <algorithm>
#include <cmath>

namespace kiln {

EdgeLayers::EdgeLayers(const PixelRect& rect, std::uint64_t pixel_bytes) : lists_(rect, pixel_bytes * rect.count()) {}

std::uint64_t EdgeLayers::bytesFor(std::uint64_t pixels, std::uint64_t pixel_bytes) {
  return PixelLists<EdgeLayer>::bytesFor(pixels, 0) + pixel_bytes * pixels;
}

void EdgeLayers::put(int x, int y, const EdgeLayer& layer) {
  if (lists_.append(x, y, layer)) return;
  incomplete_.store(true, std::memory_order_relaxed);
  if (lists_.count(x, y) == 0) return;
  // One layer of both, which is the same where nothing is in front of it.
  EdgeLayer& last = lists_.last(x, y);
  const float part = std::max(last.part, layer.part);
  const float seen = layer.part - std::min(last.part, layer.part) * last.rgba[3];
  for (std::size_t c = 0; c < 4; ++c) last.rgba[c] = (last.part * last.rgba[c] + seen * layer.rgba[c]) / part;
  last.part = part;
}

void EdgeLayers::add(int x, int y, EdgeLayer slab, float alpha_in_front) {
  const bool whole = slab.part >= kWhole;
  const int count = lists_.count(x, y);
  if (count == 0 && (whole || alpha_in_front > 0)) return;
  if (count > 0 && lists_.last(x, y).part == 1) {
    EdgeLayer& last = lists_.last(x, y);
    const float seen = slab.part * (1 - last.rgba[3]);
    for (std::size_t c = 0; c < 4; ++c) last.rgba[c] += seen * slab.rgba[c];
    return;
  }
  if (whole) {
    for (float& v : slab.rgba) v *= slab.part;
    slab.part = 1;
  }
  put(x, y, slab);
}

void layBehind(const EdgeLayer& layer, float* pixel, float& covered) {
  constexpr float kLeast = 1.0f / 255;
  const float density = std::min(pixel[3] / std::max(covered, kLeast), 1.0f);
  const float seen = layer.part - std::min(layer.part, covered) * density;
  for (std::size_t c = 0; c < 4; ++c) pixel[c] += seen * layer.rgba[c];
  covered = std::max(covered, std::ceil(layer.part * 255) / 255);
}

}  // namespace kiln
