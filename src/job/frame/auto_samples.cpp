#include "job/frame/auto_samples.h"

#include <algorithm>
#include <optional>

#include "job/job_facts.h"
#include "scene/sampling.h"

namespace kiln {
namespace {

// Least edge of a voxel for which one sample is enough (experiment: job/decisions/samples-a-pixel.md). The edge is 3/4
// minus the rounding error of a depth, so that rounding does not decide for scenes of exactly 3/4. unit: pixels.
constexpr double kLargeEnough = 0.75 - 1e-9;
// Edge of a voxel from which one sample suffices while the camera moves: details between rays flicker.
// Measured: turned by 0.1 degree, scanned heads at 1 and 2 pixels a voxel change 1.3 to 2.1 times as much as with 16
// rays a pixel, with 4 rays 0.7 to 1.15 times; at 5 pixels a voxel one ray changes as much. unit: pixels.
constexpr double kSteadyEnough = 4 - 1e-9;
// Edge of a voxel from which one sample suffices for labels, whose edges are steps. Solid labels at 1, 1.5 and 2
// pixels a voxel have 34.5, 37.8, 37.7 dB with one ray and 39.8, 38.6, 37.8 dB with four. unit: pixels.
constexpr double kLabelsLargeEnough = 1.25 - 1e-9;
constexpr int kMostAlongEdge = 4;

// Returns true for kinds of pictures with one sample a pixel: voxel lattice, projections, deep images, panoramas.
bool oneOnly(const RenderJob& job, const Camera& camera) {
  return !engineOf(job).capabilities().filters_rays || camera.projection == Projection::kEquirectangular ||
         drawsDeep(job);
}

// Returns the size of a world unit at `centre`; nothing if `centre` is behind the eye. unit: pixels.
std::optional<double> pixelsPerUnit(const Camera& camera, const ImageSize& size, const glm::dvec3& centre) {
  const View view = resolve(camera, size);
  if (view.projection == Projection::kOrthographic) return view.focal_px;
  const double depth = (view.view_from_world * glm::dvec4(centre, 1)).z;
  return depth > 0 ? std::optional(view.focal_px / depth) : std::nullopt;
}

const VolumeGeometry& levelOf(const Manifest& volume, int level) {
  return volume.levels[std::min(static_cast<std::size_t>(level), volume.levels.size() - 1)].geometry;
}

// Returns whether the path has more than one camera; a path of one camera is a still picture.
struct HasSeveralCameras {
  bool operator()(std::monostate) const { return false; }
  bool operator()(const Turntable& turn) const { return turn.frames > 1; }
  bool operator()(const CameraKeyframes& path) const { return path.keys.size() > 1; }
  bool operator()(const CameraMatrices& cameras) const { return cameras.size() > 1; }
};

}  // namespace

int automaticSamples(const RenderJob& job, const Camera& camera, const glm::dvec3& centre,
                     const std::vector<const Manifest*>& volumes) {
  if (oneOnly(job, camera)) return 1;
  const PictureOptions& picture = job.picture;
  const std::optional<double> scale = pixelsPerUnit(camera, picture.size, centre);
  if (!scale) return 1;
  const std::int64_t pixels = std::int64_t{picture.size.width} * picture.size.height;
  const bool moves = std::visit(HasSeveralCameras(), job.animation.camera);
  const bool labels = std::all_of(volumes.begin(), volumes.end(),
                                  [](const Manifest* volume) { return volume->volume_class == VolumeClass::kLabels; });
  const double enough_of_one = moves ? kSteadyEnough : labels ? kLabelsLargeEnough : kLargeEnough;
  const auto small = [&](const Manifest* volume, int edge) {
    const double enough = edge == 1 ? enough_of_one : kLargeEnough;
    return edge * *scale * levelOf(*volume, picture.level.value_or(0)).shortestEdge() < enough;
  };
  const auto affordable = [&](const Manifest* volume, int edge) {
    const int shown = picture.level ? *picture.level : levelAtScale(*volume, edge * *scale);
    // Rays without a finer level read nothing more.
    if (enough_of_one > kLargeEnough && edge == 2 && shown == levelAtScale(*volume, *scale)) return true;
    return levelOf(*volume, shown).dims.count() <= kMostOversampledVoxels;
  };
  int edge = 1;
  while (edge < kMostAlongEdge) {
    const int twice = 2 * edge;
    if (std::none_of(volumes.begin(), volumes.end(), [&](const Manifest* volume) { return small(volume, edge); }))
      break;
    if (twice * twice * pixels > kMostSubPixels) break;
    if (!std::all_of(volumes.begin(), volumes.end(), [&](const Manifest* volume) { return affordable(volume, twice); }))
      break;
    edge = twice;
  }
  return edge * edge;
}

}  // namespace kiln
