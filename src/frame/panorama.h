// A panorama: all directions round the eye. Slabs are planes, so it is drawn as the twelve faces of a dodecahedron, in
// perspective, each a little larger than a face, and then resampled: every pixel is the mean of four directions, each
// looked up in the faces that show it, which fade into one another at their edges. (Of a cube's faces the corners are
// 55 degrees from the middle, where samples lie so far apart that a translucent medium has gaps: 4 % of its alpha, of
// these 37 degrees and 1 %.)
#pragma once

#include <array>
#include <cstddef>

#include "frame/render_frame.h"

namespace kiln {

inline constexpr std::size_t kPanoramaFaces = 12;

/// The faces' views: cameras in the panorama's eye.
std::array<View, kPanoramaFaces> panoramaFaces(const View& panorama);
/// What draws a face. Its pixels, of rays, too, are samples: the panorama's are means of several.
FrameRequest faceOf(const FrameRequest& panorama, const View& face);
/// Of each face, the pixels that the panorama's `pixels` are made of; may be empty.
std::array<PixelRect, kPanoramaFaces> facePixels(const View& panorama, const PixelRect& pixels);

/// As renderFrame, of an equirectangular view. Depths are distances from the eye. Statistics are sums over the faces;
/// bricks in total and damaged ones count once. requires: one sample a pixel, nothing deep, no part.
Image renderPanorama(const StoreReader& store, BrickCache& cache, const FrameRequest& request, Progress& progress,
                     FrameStatistics& statistics);

}  // namespace kiln
