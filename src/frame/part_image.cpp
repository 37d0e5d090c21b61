#include "frame/part_image.h"

#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "base/thread/parallel.h"
#include "frame/pass/aov_planes.h"
#include "job/job_facts.h"

namespace kiln {
namespace {

void layPixelBehind(const float* behind, const AovPixels& planes_behind, float opacity_threshold, float* front,
                    const AovPixels& planes) {
  const float before = front[3], open = 1 - before;
  if (before == 1.0f || behind[3] == 0.0f) return;
  for (int c = 0; c < 4; ++c) front[c] += open * behind[c];
  const bool closes = front[3] >= opacity_threshold;
  const float scale = closes ? 1 / front[3] : 1;
  if (planes.first != nullptr && hitsFirst(before, front[3], closes))
    *planes.first = behind[3] >= kHitAlpha ? *planes_behind.first : *planes_behind.mean / behind[3];
  glm::vec3 normal(0);
  for (int axis = 0; axis < 3 && planes.normal[0] != nullptr; ++axis) normal[axis] = open * *planes_behind.normal[axis];
  planes.add(0, planes.mean == nullptr ? 0 : open * *planes_behind.mean, normal, scale);
  if (!closes) return;
  for (int c = 0; c < 3; ++c) front[c] *= scale;
  front[3] = 1.0f;
}

PixelFilter filterOf(const PictureOptions& picture) {
  return pixelFilterOf(engineOf(picture), picture.samples.value_or(1));
}

}  // namespace

SampleWindow sampleWindowOf(const PictureOptions& picture) {
  const PixelFilter filter = filterOf(picture);
  const int edge = filter.edge();
  return {filter.samplesOf(drawnPixels(picture.size, picture.crop), picture.size),
          {edge * picture.size.width, edge * picture.size.height}};
}

void premultiplyPlanes(const Aovs& aovs, const View& view, Image& samples) {
  if (!aovs.any()) return;
  const glm::mat3 world_from_view = glm::transpose(glm::mat3(view.view_from_world));
  const auto origin = static_cast<float>(view.origin_depth);
  parallelFor(static_cast<std::size_t>(samples.height), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < samples.width; ++x) {
      const AovPixels at = aovPixels(aovs, samples, x, y);
      if (at.mean != nullptr) *at.first += origin, *at.mean += samples.pixel(x, y)[3] * origin;
      if (at.normal[0] == nullptr) continue;
      const glm::vec3 normal = world_from_view * glm::vec3(*at.normal[0], *at.normal[1], *at.normal[2]);
      for (int axis = 0; axis < 3; ++axis) *at.normal[axis] = normal[axis];
    }
  });
}

Image emptyPart(const PixelRect& samples, const Aovs& aovs) {
  Image out(samples.width(), samples.height());
  addAovPlanes(aovs, out);
  return out;
}

void layBehind(Image& behind, const Aovs& aovs, int x0, int y0, float opacity_threshold, Image& front) {
  parallelFor(static_cast<std::size_t>(behind.height), [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < behind.width; ++x)
      layPixelBehind(behind.pixel(x, y), aovPixels(aovs, behind, x, y), opacity_threshold, front.pixel(x0 + x, y0 + y),
                     aovPixels(aovs, front, x0 + x, y0 + y));
  });
}

Image pixelsOf(Image& samples, const PictureOptions& picture, const Aovs& aovs) {
  const PixelFilter filter = filterOf(picture);
  const PixelRect pixels = drawnPixels(picture.size, picture.crop), drawn = sampleWindowOf(picture).samples;
  Image out = emptyPart(pixels, aovs);
  filter.put(samples, drawn, pixels, out, 0);
  // The planes are in the world already, so a view without rotation and origin leaves them unchanged.
  const int edge = filter.edge();
  putAovs(aovs, View(), {samples, edge, edge * pixels.x0 - drawn.x0, edge * pixels.y0 - drawn.y0, out.height}, out, 0);
  return out;
}

}  // namespace kiln
