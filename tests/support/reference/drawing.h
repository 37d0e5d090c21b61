// Draws a frame of a store, for tests of the picture.
#pragma once

#include <filesystem>
#include <vector>

#include "frame/render_frame.h"

namespace kiln::test {

/// Opens the store with a separate cache and draws a frame.
Image draw(const std::filesystem::path& store, const FrameRequest& request, std::uint64_t budget_bytes = 1ull << 30,
           FrameStatistics* statistics = nullptr);

/// Draws several volumes in a picture: the volumes of the request.
Image draw(const std::vector<std::filesystem::path>& stores, const FrameRequest& request,
           std::uint64_t budget_bytes = 1ull << 30, FrameStatistics* statistics = nullptr);

/// Draws open volumes.
Image draw(const std::vector<const BrickedVolume*>& volumes, const FrameRequest& request,
           std::uint64_t budget_bytes = 1ull << 30, FrameStatistics* statistics = nullptr);

/// Draws an open volume.
Image draw(const BrickedVolume& volume, const FrameRequest& request, std::uint64_t budget_bytes = 1ull << 30,
           FrameStatistics* statistics = nullptr);

/// Returns true for equal sizes and bitwise equal floats, including planes, the sign of zero and the kind of NaN.
bool equalBits(const Image& a, const Image& b);

/// Returns true if any pixel is not clear.
bool showsSomething(const Image& image);

/// Value of a plane at a pixel. An absent plane fails the test.
float planeAt(const Image& image, const char* name, int x, int y);
/// Normal of a pixel, from its planes.
glm::dvec3 normalAt(const Image& image, int x, int y);

/// requires: `rect` inside of the image.
Image partOf(const Image& whole, const PixelRect& rect);
/// The image without planes.
Image colorsOf(Image image);

/// Returns a camera that sees the volume's whole box, with the eye in direction `from` (world, any length).
Camera cameraFrom(const VolumeGeometry& volume, const glm::dvec3& from, Projection projection);

/// A request for a square picture of the finest level, with depths and normals, unfiltered, from such a camera.
FrameRequest answerRequest(const VolumeGeometry& volume, const glm::dvec3& from, Projection projection, int pixels);

/// The seed's n-th direction, uniform on the sphere.
glm::dvec3 randomDirection(std::uint64_t seed, std::uint64_t n);

}  // namespace kiln::test
