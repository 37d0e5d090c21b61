// What a picture tells of its pixels beside colour, while they are drawn: sums over what a pixel shows, each part of it
// weighted by the opacity that it adds, as its premultiplied colour is. A pixel that is closed is divided by its alpha,
// so that sums over alpha are means all the way.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>

namespace kiln {

/// A pixel's first hit is where its alpha passes this.
inline constexpr float kHitAlpha = 0.5f;

/// The planes of a tile; null where nobody asked. shape: each points at the tile's first pixel, a float a pixel, rows
/// as far apart as the tile's, which is `stride` / 4 floats.
struct AovPixels {
  float* first = nullptr;  // depth of the first hit; anything where alpha is less than kHitAlpha. unit: world
  float* mean = nullptr;   // sum of depths. unit: world
  float* normal[3]{};      // sum of unit vectors in view space

  bool any() const { return mean != nullptr || normal[0] != nullptr; }
  AovPixels from(std::ptrdiff_t pixels) const {
    const auto at = [&](float* plane) { return plane == nullptr ? nullptr : plane + pixels; };
    return {at(first), at(mean), {at(normal[0]), at(normal[1]), at(normal[2])}};
  }
  /// `pixel` becomes more by what adds `depth` and `normal`, both premultiplied, and is then scaled.
  void add(std::ptrdiff_t pixel, float depth, const glm::vec3& unit, float scale) const {
    if (mean != nullptr) mean[pixel] = scale * (mean[pixel] + depth);
    if (normal[0] == nullptr) return;
    for (int axis = 0; axis < 3; ++axis) normal[axis][pixel] = scale * (normal[axis][pixel] + unit[axis]);
  }
};

}  // namespace kiln
