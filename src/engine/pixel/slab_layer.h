// Contribution of one slab to a pixel's AOVs (depth and normal).
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>

#include "engine/shared/aov_pixels.h"

namespace kiln {

struct SlabLayer {
  float before = 0, added = 0;  // the pixel's alpha before the slab; alpha added by the slab, before closing
  bool closes = false;          // the slab closes the pixel
  float opacity = 0;            // opacity of the slab
  double middle = 0;            // depth of the slab's middle. unit: world
  double thickness = 1;         // unit: world
  glm::vec3 normal{0};          // premultiplied
};

/// Adds the layer to the pixel's sums. If the pixel's alpha passes one half in the layer, stores the depth of the first
/// hit. requires: layers of a pixel come front to back; the pixel is not closed.
void addLayer(const SlabLayer& layer, const AovPixels& aovs, std::ptrdiff_t pixel) noexcept;

}  // namespace kiln
