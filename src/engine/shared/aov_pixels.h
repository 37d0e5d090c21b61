// AOV planes of a tile while it is drawn: sums of depth and normal, each contribution weighted by the opacity it adds,
// like premultiplied colour.
// Invariant. A closed pixel's sums are divided by its alpha, as its colour is, so that sum / alpha is always the mean.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>

namespace kiln {

/// Alpha at which a pixel has its first hit.
inline constexpr float kHitAlpha = 0.5f;

/// True if a pixel whose alpha rises from `before` to `after` has its first hit: a pixel that closes earlier, too.
inline bool hitsFirst(float before, float after, bool closes) {
  return before < kHitAlpha && (after >= kHitAlpha || closes);
}

/// AOV planes of a tile; null if not requested. shape: pointers to the tile's first pixel, one float per pixel, rows
/// `stride` / 4 floats apart (the tile's stride).
struct AovPixels {
  float* first = nullptr;  // depth of the first hit; undefined while alpha < kHitAlpha. unit: world
  float* mean = nullptr;   // sum of depths. unit: world
  float* normal[3]{};      // sum of unit vectors in view space
  float* value = nullptr;  // a projected value, NaN where there is none; written when all bricks are drawn

  bool any() const { return mean != nullptr || normal[0] != nullptr; }
  AovPixels from(std::ptrdiff_t pixels) const {
    const auto at = [&](float* plane) { return plane == nullptr ? nullptr : plane + pixels; };
    return {at(first), at(mean), {at(normal[0]), at(normal[1]), at(normal[2])}, at(value)};
  }
  /// Adds premultiplied depth and normal to a pixel, then multiplies the pixel's sums by `scale`.
  void add(std::ptrdiff_t pixel, float depth, const glm::vec3& unit, float scale) const {
    if (mean != nullptr) mean[pixel] = scale * (mean[pixel] + depth);
    if (normal[0] == nullptr) return;
    for (int axis = 0; axis < 3; ++axis) normal[axis][pixel] = scale * (normal[axis][pixel] + unit[axis]);
  }
};

}  // namespace kiln
