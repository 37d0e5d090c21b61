#include "support/reference/drawing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>

#include "base/thread/parallel.h"
#include "store/store_reader.h"
#include "support/volumes/procedural.h"

namespace kiln::test {

Image draw(const std::filesystem::path& store, const FrameRequest& request, std::uint64_t budget_bytes,
           FrameStatistics* statistics) {
  return draw(std::vector{store}, request, budget_bytes, statistics);
}

Image draw(const std::vector<std::filesystem::path>& stores, const FrameRequest& request, std::uint64_t budget_bytes,
           FrameStatistics* statistics) {
  std::vector<std::unique_ptr<StoreReader>> opened;
  std::vector<const BrickedVolume*> readers;
  for (const std::filesystem::path& store : stores) {
    opened.push_back(std::make_unique<StoreReader>(store));
    readers.push_back(opened.back().get());
  }
  return draw(readers, request, budget_bytes, statistics);
}

Image draw(const std::vector<const BrickedVolume*>& volumes, const FrameRequest& request, std::uint64_t budget_bytes,
           FrameStatistics* statistics) {
  // As in the program: a single thread has no read-ahead.
  BrickCache cache(volumes, budget_bytes, ThreadLimit::active() == 1 ? 0 : 2);
  Progress silent;
  FrameStatistics unused;
  return renderFrame(cache, request, silent, statistics != nullptr ? *statistics : unused);
}

Image draw(const BrickedVolume& volume, const FrameRequest& request, std::uint64_t budget_bytes,
           FrameStatistics* statistics) {
  return draw(std::vector<const BrickedVolume*>{&volume}, request, budget_bytes, statistics);
}

bool equalBits(const Image& a, const Image& b) {
  const auto equal = [](const ZeroPages<float>& p, const ZeroPages<float>& q) {
    return p.size() == q.size() && std::memcmp(p.data(), q.data(), p.size() * sizeof(float)) == 0;
  };
  const auto same = [&](const Plane& p, const Plane& q) { return p.name == q.name && equal(p.values, q.values); };
  return a.width == b.width && a.height == b.height && equal(a.rgba, b.rgba) &&
         std::equal(a.planes.begin(), a.planes.end(), b.planes.begin(), b.planes.end(), same);
}

bool showsSomething(const Image& image) {
  for (std::size_t at = 3; at < image.rgba.size(); at += 4) {
    if (image.rgba[at] > 0) return true;
  }
  return false;
}

float planeAt(const Image& image, const char* name, int x, int y) {
  for (const Plane& plane : image.planes)
    if (plane.name == name) return plane.values[static_cast<std::size_t>(y * image.width + x)];
  ADD_FAILURE() << "no plane " << name;
  return 0;
}

glm::dvec3 normalAt(const Image& image, int x, int y) {
  return {planeAt(image, "N.X", x, y), planeAt(image, "N.Y", x, y), planeAt(image, "N.Z", x, y)};
}

Image partOf(const Image& whole, const PixelRect& rect) {
  Image out(rect.width(), rect.height());
  for (const Plane& plane : whole.planes) out.planes.push_back({plane.name, ZeroPages<float>(rect.count())});
  for (int y = rect.y0; y < rect.y1; ++y) {
    std::copy(whole.pixel(rect.x0, y), whole.pixel(rect.x0, y) + 4 * rect.width(), out.pixel(0, y - rect.y0));
    for (std::size_t i = 0; i < whole.planes.size(); ++i) {
      const float* const row = whole.planes[i].values.begin() + std::ptrdiff_t{y} * whole.width;
      std::copy(row + rect.x0, row + rect.x1,
                out.planes[i].values.begin() + std::ptrdiff_t{y - rect.y0} * rect.width());
    }
  }
  return out;
}

Image colorsOf(Image image) {
  image.planes.clear();
  return image;
}

Camera cameraFrom(const VolumeGeometry& volume, const glm::dvec3& from, Projection projection) {
  const Extent3& n = volume.dims;
  const glm::dvec3 centre = volume.worldOf(glm::dvec3(n.x - 1, n.y - 1, n.z - 1) / 2.0);
  double radius = 0;
  for (const glm::dvec3& corner : volume.corners()) radius = std::max(radius, glm::length(corner - centre));
  const glm::dvec3 direction = glm::normalize(from);
  Camera camera;
  camera.projection = projection;
  camera.target = centre;
  camera.eye = centre + direction * (3.0 * radius);
  camera.up = std::abs(direction.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0);
  camera.height = 2.05 * radius;
  camera.fov_deg = 2 * std::asin(1.025 / 3.0) * 180 / std::numbers::pi;
  return camera;
}

FrameRequest answerRequest(const VolumeGeometry& volume, const glm::dvec3& from, Projection projection, int pixels) {
  FrameRequest out;
  out.view = resolve(cameraFrom(volume, from, projection), {pixels, pixels});
  out.level = 0;
  out.aovs = {true, true};
  out.filters_rays = false;
  return out;
}

glm::dvec3 randomDirection(std::uint64_t seed, std::uint64_t n) {
  const double z = 2 * hashUnit(seed, 2 * n) - 1;
  const double angle = 2 * std::numbers::pi * hashUnit(seed, 2 * n + 1);
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

}  // namespace kiln::test
