// Partial images: the samples (sub-pixels) of a picture that lie in a box of voxels, before the pixel filter. A sample
// belongs to one box, so partial images are composited by *over* and filtered last. All channels but Z are
// premultiplied. Source: Porter and Duff 1984.
#pragma once

#include "frame/pixel_filter.h"
#include "image/image.h"
#include "image/pixel_rect.h"
#include "job/render_job.h"

namespace kiln {

/// The samples of a partial image, and the size of the whole picture in samples.
struct SampleWindow {
  PixelRect samples;
  ImageSize picture;
};
/// requires: `picture.samples` is resolved; without a number a pixel has one sample.
SampleWindow sampleWindowOf(const PictureOptions& picture);

/// Converts planes of sums (engine/shared/aov_pixels.h) to the planes of a partial image: depths and normals in the
/// world, means and normals multiplied by alpha.
void premultiplyPlanes(const Aovs& aovs, const View& view, Image& samples);

/// Returns an empty partial image.
Image emptyPart(const PixelRect& samples, const Aovs& aovs);

/// Composites `behind` behind the samples of `front` from (x, y) on. A sample that reaches `opacity_threshold` is
/// divided by its alpha and closed, as in drawing. The depth of the first hit comes from the part in which alpha passes
/// 1/2; if the part alone stays below 1/2, from the part's mean depth. requires: `behind` fits; both images have the
/// planes of `aovs`.
void layBehind(Image& behind, const Aovs& aovs, int x, int y, float opacity_threshold, Image& front);

/// Filters composited samples to pixels, without a background. requires: `samples` cover sampleWindowOf.
Image pixelsOf(Image& samples, const PictureOptions& picture, const Aovs& aovs);

}  // namespace kiln
