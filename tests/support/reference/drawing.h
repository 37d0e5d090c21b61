// Draws a frame of a store, for tests that ask what is in the picture.
#pragma once

#include <filesystem>
#include <vector>

#include "frame/render_frame.h"

namespace kiln::test {

/// Opens the store with a cache of its own and draws one frame.
Image draw(const std::filesystem::path& store, const FrameRequest& request, std::uint64_t budget_bytes = 1ull << 30,
           FrameStatistics* statistics = nullptr);

/// Several volumes in one picture: those of the request.
Image draw(const std::vector<std::filesystem::path>& stores, const FrameRequest& request,
           std::uint64_t budget_bytes = 1ull << 30, FrameStatistics* statistics = nullptr);

/// Whether they have the same size and every float is the same, planes' too, the sign of zero and the kind of NaN
/// included.
bool equalBits(const Image& a, const Image& b);

/// Whether any pixel is not clear.
bool showsSomething(const Image& image);

/// requires: `rect` inside of the image.
Image partOf(const Image& whole, const PixelRect& rect);
/// The image without planes.
Image colorsOf(Image image);

/// A camera that sees all of the volume's box, the eye in direction `from` (world, any length).
Camera cameraFrom(const VolumeGeometry& volume, const glm::dvec3& from, Projection projection);

/// The seed's n-th direction, uniform on the sphere.
glm::dvec3 randomDirection(std::uint64_t seed, std::uint64_t n);

}  // namespace kiln::test
