// Planes of a picture beside its colours (defined in scene/render_options.h): allocation, access for engines, and
// conversion of sums to values.
#pragma once

#include <cstdint>

#include "engine/shared/aov_pixels.h"
#include "image/image.h"
#include "scene/camera/camera.h"
#include "scene/render_options.h"

namespace kiln {

/// Memory of the planes, including memory for drawing. unit: bytes per pixel.
std::uint64_t aovBytes(const Aovs& aovs);

/// Appends the planes of `aovs` to a picture that has none. No pixel is hit yet.
void addAovPlanes(const Aovs& aovs, Image& image);

/// Returns the planes of the picture, from pixel (x, y) on. requires: the picture has the planes of `aovs`.
AovPixels aovPixels(const Aovs& aovs, Image& image, int x, int y);

/// Rows of pixels in an image of their sub-pixels: `rows` rows, the first of them edge × edge sub-pixels from (x, y)
/// on.
struct SubPixels {
  Image& image;
  int edge, x, y, rows;
};

/// Converts the sums of each pixel's sub-pixels, alpha included, and writes the values into the image's rows from `row`
/// on. With one sample a pixel, the sums may be in `image` itself. requires: both images have the planes of `aovs`; no
/// background.
void putAovs(const Aovs& aovs, const View& view, const SubPixels& from, Image& image, int row);

}  // namespace kiln
