// Partial images: the samples (sub-pixels) of a picture that lie in a box of voxels, before the pixel filter. A sample
// belongs to one box, so that partial images are composited by the operator "over" (Porter and Duff, "Compositing
// digital images", 1984), and the pixel filter comes last. All channels but Z are premultiplied.
#pragma once

#include "frame/pixel_filter.h"
#include "image/image.h"
#include "image/pixel_rect.h"
#include "job/render_job.h"

namespace kiln {

/// Samples that a partial image holds, and the size of the whole picture in samples.
struct SampleWindow {
  PixelRect samples;
  ImageSize picture;
};
/// requires: `picture.samples` is resolved, or 1 is meant.
SampleWindow sampleWindowOf(const PictureOptions& picture);

/// Makes planes of sums (engine/shared/aov_pixels.h) the planes of a partial image: depths and normals of the world,
/// means and normals multiplied by alpha.
void premultiplyPlanes(const Aovs& aovs, const View& view, Image& samples);

/// An empty partial image, in front of which nothing lies.
Image emptyPart(const PixelRect& samples, const Aovs& aovs);

/// Lays `behind` behind the samples of `front` from (x, y) on. A sample that reaches `opaque_at` is divided by its
/// alpha and closed, as when it is drawn. The depth of the first hit is that of the part in which alpha passes one
/// half: the part's own, or where the part alone stays below one half, its mean. requires: `behind` fits; both have the
/// planes of `aovs`.
void layBehind(Image& behind, const Aovs& aovs, int x, int y, float opaque_at, Image& front);

/// The pixels that composited samples make, without background. requires: `samples` are those of sampleWindowOf.
Image pixelsOf(Image& samples, const PictureOptions& picture, const Aovs& aovs);

}  // namespace kiln
