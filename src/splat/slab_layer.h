// What one slab lays behind a pixel, and where in the slab it is: finer than slabs are thick, for the planes of depth.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>

#include "splat/aov_pixels.h"

namespace kiln {

struct SlabLayer {
  float before = 0, added = 0;  // the pixel's alpha, and what the slab adds to it, not closed yet
  bool closes = false;          // whether the pixel is closed now
  float filled = 0;             // what of the slab samples fill, from 0 to 1
  float turn = 0.5f;            // from which filling on a slab covers half the pixel, one half or more; 0 on rays
  float opacity = 0;            // of what they fill
  float place = 0;              // its mean depth, from the slab's middle. unit: slabs
  double middle = 0;            // the depth of the slab's middle. unit: world
  double thickness = 1;         // unit: world
  glm::vec3 normal{0};          // premultiplied
};

/// Adds the layer to the pixel's sums; where it is the one in which the pixel's alpha passes one half, notes the depth.
/// requires: layers of a pixel come from front to back, the pixel not closed.
void addLayer(const SlabLayer& layer, const AovPixels& aovs, std::ptrdiff_t pixel) noexcept;

}  // namespace kiln
