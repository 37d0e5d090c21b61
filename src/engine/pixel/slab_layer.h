// What one slab lays behind a pixel, for the planes of depth and normals.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>

#include "engine/shared/aov_pixels.h"

namespace kiln {

struct SlabLayer {
  float before = 0, added = 0;  // the pixel's alpha, and what the slab adds to it, not closed yet
  bool closes = false;          // whether the pixel is closed now
  float opacity = 0;            // of the slab
  double middle = 0;            // the depth of the slab's middle. unit: world
  double thickness = 1;         // unit: world
  glm::vec3 normal{0};          // premultiplied
};

/// Adds the layer to the pixel's sums; where it is the one in which the pixel's alpha passes one half, notes the depth.
/// requires: layers of a pixel come from front to back, the pixel not closed.
void addLayer(const SlabLayer& layer, const AovPixels& aovs, std::ptrdiff_t pixel) noexcept;

}  // namespace kiln
