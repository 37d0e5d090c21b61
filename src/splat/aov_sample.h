// What a sample adds to the planes of a pixel beside its colour, on its way to its slab as the sample itself is.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>

#include "splat/refine_unit.h"

namespace kiln {

struct AovSample {
  FootprintPlace place;
  float front, back;              // what it fills of its two slabs, times its opacity
  float depth_front, depth_back;  // of these two parts, from the middles of their slabs. unit: slabs
  glm::vec3 normal;               // in view space, of unit length or 0
};

/// `depth` is the sample's own. A part's depth is the middle of what the slab cuts off from one box as deep as the
/// sample's two, folded, deviate. unit: slabs.
inline AovSample aovSample(const SlabSample& s, int slab, float depth, const DepthSpread& spread,
                           const glm::vec3& normal) {
  const float half = 0.5f * std::sqrt(spread.a * spread.a + spread.b * spread.b);
  const auto middle = [&](float from_middle) {
    const auto inside = [](float at) { return std::clamp(at, -0.5f, 0.5f); };
    return 0.5f * (inside(from_middle - half) + inside(from_middle + half));
  };
  const float from_middle = depth - static_cast<float>(slab) - 0.5f;
  return {s.place, s.front * s.opacity, s.back * s.opacity, middle(from_middle), middle(from_middle - 1), normal};
}

}  // namespace kiln
