#include "engine/pixel/slab_layer.h"

#include <algorithm>
#include <cmath>

namespace kiln {
namespace {

float opticalDepth(const SlabLayer& layer) { return -std::log1p(-std::min(layer.opacity, 1 - 1e-6f)); }

// Mean depth of the light that leaves a uniform layer of optical depth x, as a fraction of its thickness: 1/x -
// 1/(exp(x) - 1).
float meanOf(float x) { return x < 0.01f ? 0.5f - x / 12 : 1 / x - 1 / std::expm1(x); }

// Depth at which the pixel's alpha passes one half, as a fraction of the layer's thickness.
float hitOf(const SlabLayer& layer, float x) {
  return std::min(std::log((1 - layer.before) / (1 - kHitAlpha)) / x, 1.0f);
}

}  // namespace

void addLayer(const SlabLayer& layer, const AovPixels& aovs, std::ptrdiff_t pixel) noexcept {
  const float x = opticalDepth(layer);
  const auto depthOf = [&](float from_begin) {
    return static_cast<float>(layer.middle + (static_cast<double>(from_begin) - 0.5) * layer.thickness);
  };
  aovs.add(pixel, layer.added * depthOf(meanOf(x)), layer.normal, layer.closes ? 1 / (layer.before + layer.added) : 1);
  if (aovs.first != nullptr && hitsFirst(layer.before, layer.before + layer.added, layer.closes))
    aovs.first[pixel] = depthOf(hitOf(layer, x));
}

}  // namespace kiln
