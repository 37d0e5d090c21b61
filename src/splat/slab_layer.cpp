#include "splat/slab_layer.h"

#include <algorithm>
#include <cmath>

namespace kiln {
namespace {

// Of a full slab of what is in this one.
float opticalDepth(const SlabLayer& layer) { return -std::log1p(-std::min(layer.opacity, 1 - 1e-6f)); }

// Where in a uniform layer of optical depth x the light comes from that it sends, in the mean: the part of it in front.
float meanOf(float x) { return x < 0.01f ? 0.5f - x / 12 : 1 / x - 1 / std::expm1(x); }

// How far into the layer the pixel's alpha passes one half. unit: slabs.
float hitOf(const SlabLayer& layer, float x) {
  return std::min(std::log((1 - layer.before) / (1 - kHitAlpha)) / x, layer.filled);
}

// Where the layer begins, from the slab's middle. A slab in front that did not cover half the pixel was the edge of
// what fills this one, a surface that lies where the filling passes one half on the line through both middles. unit:
// slabs.
float beginOf(const SlabLayer& layer, float filled_before) {
  if (filled_before >= layer.turn) return -0.5f;
  if (layer.filled < 0.5f || layer.filled <= filled_before) return layer.place - 0.5f * layer.filled;
  return std::max((0.5f - filled_before) / (layer.filled - filled_before), -0.5f) - 1;
}

}  // namespace

void addLayer(const SlabLayer& layer, const AovPixels& aovs, std::ptrdiff_t pixel) noexcept {
  const float x = opticalDepth(layer);
  const auto depthOf = [&](float from_middle) {
    return static_cast<float>(layer.middle + from_middle * layer.thickness);
  };
  const float mean = layer.place + layer.filled * (meanOf(layer.filled * x) - 0.5f);
  aovs.add(pixel, layer.added * depthOf(mean), layer.normal, layer.closes ? 1 / (layer.before + layer.added) : 1);
  if (aovs.first == nullptr || layer.before >= kHitAlpha) return;
  // Until the pixel is hit, its depth says which slab was the last, whose filling is noted beside it.
  float& first = aovs.first[pixel];
  float& filled = aovs.filled[pixel];
  const bool next = std::abs(layer.middle - first) < 1.5 * layer.thickness;
  const float begin = beginOf(layer, next ? filled : 0);
  const bool hit = layer.closes || layer.before + layer.added >= kHitAlpha;
  first = depthOf(hit ? begin + hitOf(layer, x) : 0);
  filled = layer.filled;
}

}  // namespace kiln
