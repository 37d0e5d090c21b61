#include "scene/auto_samples.h"

#include <algorithm>
#include <optional>

#include "scene/sampling.h"

namespace kiln {
namespace {

// Of a voxel's edge, from which on nothing is won that is missed (ARCHITECTURE.md has the figures); less by what a
// depth's rounding is, so that it does not decide where a scene is laid out for 3/4. unit: pixels.
constexpr double kLargeEnough = 0.75 - 1e-9;
constexpr int kMostAlongEdge = 4;

// What else there is of a picture has one sample a pixel, or is Lee and Ihm's own.
bool oneOnly(const RenderJob& job, const Camera& camera) {
  return job.picture.lattice == Lattice::kVoxel || camera.projection == Projection::kEquirectangular ||
         drawsDeep(job) || drawsPart(job.picture);
}

// Of a unit of the world at `centre`; none where it is not in front of the eye.
std::optional<double> pixelsPerUnit(const Camera& camera, const ImageSize& size, const glm::dvec3& centre) {
  const View view = resolve(camera, size);
  if (view.projection == Projection::kOrthographic) return view.focal_px;
  const double depth = (view.view_from_world * glm::dvec4(centre, 1)).z;
  return depth > 0 ? std::optional(view.focal_px / depth) : std::nullopt;
}

int alongEdge(const Manifest& volume, const PictureOptions& picture, double px_per_unit) {
  const auto at = [&](int level) -> const VolumeGeometry& {
    return volume.levels[static_cast<std::size_t>(level)].geometry;
  };
  const int last = static_cast<int>(volume.levels.size()) - 1;
  const double voxel_px = px_per_unit * at(std::min(picture.level.value_or(0), last)).shortestEdge();
  const std::int64_t pixels = std::int64_t{picture.size.width} * picture.size.height;
  int edge = 1;
  while (edge < kMostAlongEdge && edge * voxel_px < kLargeEnough) {
    const int twice = 2 * edge;
    const int shown = picture.level ? std::min(*picture.level, last) : levelAtScale(volume, twice * px_per_unit);
    if (twice * twice * pixels > kMostSubPixels || at(shown).dims.count() > kMostOversampledVoxels) break;
    edge = twice;
  }
  return edge;
}

}  // namespace

int automaticSamples(const RenderJob& job, const Camera& camera, const glm::dvec3& centre,
                     const std::vector<const Manifest*>& volumes) {
  if (oneOnly(job, camera)) return 1;
  const std::optional<double> scale = pixelsPerUnit(camera, job.picture.size, centre);
  int edge = 1;
  for (const Manifest* const volume : volumes) {
    if (scale) edge = std::max(edge, alongEdge(*volume, job.picture, *scale));
  }
  return edge * edge;
}

}  // namespace kiln
