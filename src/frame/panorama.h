// Problem: draw all directions around the eye with plane slabs.
// Method: draw the twelve faces of a dodecahedron in perspective, each slightly enlarged. A pixel is the mean of four
// directions, each interpolated in the faces that contain the direction; faces blend at their edges.
// Differs: a cube's corners are 55 degrees from the middle of a face. Samples there are too far apart, and a
// translucent medium loses 4 % of its alpha. A dodecahedron's corners are 37 degrees away and lose 1 %.
#pragma once

#include <array>
#include <cstddef>

#include "frame/render_frame.h"

namespace kiln {

inline constexpr std::size_t kPanoramaFaces = 12;

/// Returns the views of the faces: cameras in the panorama's eye.
std::array<View, kPanoramaFaces> panoramaFaces(const View& panorama);
/// Returns the options of a face. A face's pixels are samples of the panorama's pixels, without a pixel filter.
FrameRequest faceOf(const FrameRequest& panorama, const View& face);
/// Returns, for each face, the pixels that the panorama's `pixels` are made of; may be empty.
std::array<PixelRect, kPanoramaFaces> facePixels(const View& panorama, const PixelRect& pixels);

/// Draws an equirectangular view as renderFrame does. Depths are distances from the eye. Statistics are sums over
/// faces; total and damaged bricks count once. requires: one sample a pixel, no deep image, no part.
Image renderPanorama(BrickCache& cache, FrameRequest request, Progress& progress, FrameStatistics& statistics);

}  // namespace kiln
