#include "frame/pass/aov_planes.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>
#include <iterator>
#include <limits>

#include "base/thread/parallel.h"

namespace kiln {
namespace {

constexpr float kNothing = std::numeric_limits<float>::infinity();
constexpr const char* kDepthNames[] = {"Z", "depth.mean"};
constexpr const char* kNormalNames[] = {"N.X", "N.Y", "N.Z"};
constexpr float kNoValue = std::numeric_limits<float>::quiet_NaN();

// The sums of one pixel's sub-pixels.
struct Gathered {
  float alpha = 0, first = kNothing, mean = 0;
  glm::vec3 normal{0};

  void add(const AovPixels& from, float pixel_alpha) {
    alpha += pixel_alpha;
    if (from.mean != nullptr) {
      if (pixel_alpha >= kHitAlpha) first = std::min(first, *from.first);
      mean += *from.mean;
    }
    for (int axis = 0; axis < 3 && from.normal[0] != nullptr; ++axis) normal[axis] += *from.normal[axis];
  }
  // requires: `origin_depth` is View's.
  void put(const glm::mat3& world_from_view, double origin_depth, const AovPixels& to) const {
    if (to.mean != nullptr) {
      *to.first = static_cast<float>(first + origin_depth);
      *to.mean = alpha > 0 ? static_cast<float>(mean / alpha + origin_depth) : kNothing;
    }
    if (to.normal[0] == nullptr) return;
    const float length = glm::length(normal);
    const glm::vec3 unit = length > 0 ? world_from_view * (normal / length) : glm::vec3(0);
    for (int axis = 0; axis < 3; ++axis) *to.normal[axis] = unit[axis];
  }
};

// Averages the sub-pixels with a value among edge × edge from (x, y) on.
float meanValue(const float* values, int width, int edge, int x, int y) {
  double sum = 0;
  int count = 0;
  for (int i = 0; i < edge * edge; ++i) {
    const float value = values[std::ptrdiff_t{y + i / edge} * width + x + i % edge];
    if (std::isnan(value)) continue;
    sum += value;
    ++count;
  }
  return count > 0 ? static_cast<float>(sum / count) : kNoValue;
}

}  // namespace

std::uint64_t aovBytes(const Aovs& aovs) {
  return sizeof(float) * ((aovs.depth ? std::size(kDepthNames) + 1 : 0) + (aovs.normal ? std::size(kNormalNames) : 0) +
                          (aovs.value ? 1 : 0));
}

void addAovPlanes(const Aovs& aovs, Image& image) {
  const std::size_t pixels = image.rgba.size() / 4;
  if (aovs.depth) {
    image.planes.push_back({kDepthNames[0], ZeroPages<float>(pixels, kNothing)});
    image.planes.push_back({kDepthNames[1], ZeroPages<float>(pixels)});
  }
  for (const char* name : kNormalNames) {
    if (aovs.normal) image.planes.push_back({name, ZeroPages<float>(pixels)});
  }
  if (aovs.value) image.planes.push_back({"value", ZeroPages<float>(pixels, kNoValue)});
}

AovPixels aovPixels(const Aovs& aovs, Image& image, int x, int y) {
  AovPixels out;
  std::size_t next = 0;
  const auto plane = [&] { return image.planes[next++].values.data(); };
  if (aovs.depth) {
    out.first = plane();
    out.mean = plane();
  }
  for (int axis = 0; axis < 3 && aovs.normal; ++axis) out.normal[axis] = plane();
  if (aovs.value) out.value = plane();
  return out.from(std::ptrdiff_t{y} * image.width + x);
}

void putAovs(const Aovs& aovs, const View& view, const SubPixels& from, Image& image, int row) {
  if (!aovs.any()) return;
  const glm::mat3 world_from_view = glm::transpose(glm::mat3(view.view_from_world));
  const int edge = from.edge;
  parallelFor(static_cast<std::size_t>(from.rows), [&](std::size_t i) {
    const int y = static_cast<int>(i);
    for (int x = 0; x < image.width; ++x) {
      Gathered pixel;
      for (int j = 0; j < edge * edge; ++j) {
        const int from_x = from.x + edge * x + j % edge, from_y = from.y + edge * y + j / edge;
        pixel.add(aovPixels(aovs, from.image, from_x, from_y), from.image.pixel(from_x, from_y)[3]);
      }
      pixel.put(world_from_view, view.origin_depth, aovPixels(aovs, image, x, row + y));
      if (aovs.value)
        *aovPixels(aovs, image, x, row + y).value = meanValue(aovPixels(aovs, from.image, 0, 0).value, from.image.width,
                                                              edge, from.x + edge * x, from.y + edge * y);
    }
  });
}

}  // namespace kiln
