// The planes of a picture beside its colours (job/render_job.h says what they hold): made empty, lent to those who
// draw, and at the end made of sums what they are called.
#pragma once

#include <cstdint>

#include "engine/shared/aov_pixels.h"
#include "image/image.h"
#include "job/render_job.h"
#include "scene/camera/camera.h"

namespace kiln {

/// The planes and what drawing them takes. unit: bytes a pixel.
std::uint64_t aovBytes(const Aovs& aovs);

/// Appends the planes of `aovs` to a picture that has none. No pixel has been hit.
void addAovPlanes(const Aovs& aovs, Image& image);

/// Of the picture's planes, from pixel (x, y) on. requires: they are those of `aovs`.
AovPixels aovPixels(const Aovs& aovs, Image& image, int x, int y);

/// The plane of values, or null where `aovs` has none. requires: as above.
float* valuePlane(const Aovs& aovs, Image& image);

/// Rows of pixels in an image of their sub-pixels: `rows` of them, the first one's edge × edge sub-pixels from (x, y)
/// on.
struct SubPixels {
  Image& image;
  int edge, x, y, rows;
};

/// Writes into the image's rows from `row` on what the sums of each pixel's sub-pixels, alpha among them, come to.
/// Theirs may be `image` itself where a pixel is one. requires: both have the planes of `aovs`; no background.
void putAovs(const Aovs& aovs, const View& view, const SubPixels& from, Image& image, int row);

}  // namespace kiln
