#include "frame/empty_frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>

#include "job/frame_list.h"

namespace kiln {
namespace {

bool showsSomeGradient(const TransferFunction& function) {
  const auto& points = function.gradient_opacity;
  const auto& opacity = function.table.opacity;
  return !function.usesGradient() ||
         std::any_of(points.begin(), points.end(), [](const GradientPoint& point) { return point.factor > 0; }) ||
         std::any_of(function.regions.begin(), function.regions.end(),
                     [](const GradientRegion& region) { return region.opacity > 0; }) ||
         std::any_of(opacity.begin(), opacity.end(), [](float factor) { return factor > 0; });
}

bool showsSomeValue(const TransferFunction& function) {
  const auto opaque = [](const auto& entry) { return entry.opacity > 0; };
  if (!function.labels.empty()) return std::any_of(function.labels.begin(), function.labels.end(), opaque);
  if (!function.surfaces.empty()) return std::any_of(function.surfaces.begin(), function.surfaces.end(), opaque);
  return std::any_of(function.points.begin(), function.points.end(), opaque) && showsSomeGradient(function);
}

bool showsSomeOf(const TransferFunction& function, const ValueRange& range) {
  if (range.empty()) return false;
  if (!function.labels.empty()) return function.labelsShownIn(range.lo, range.hi);
  if (!function.surfaces.empty()) return function.surfacesCrossedIn(range.lo, range.hi);
  return function.interesting(range.lo) || function.interesting(range.hi) ||
         std::any_of(function.points.begin(), function.points.end(), [&](const TransferPoint& point) {
           return point.opacity > 0 && point.value >= range.lo && point.value <= range.hi;
         });
}

std::array<glm::dvec3, 8> cornersInView(const VolumeGeometry& volume, const View& view) {
  std::array<glm::dvec3, 8> out = volume.corners();
  for (glm::dvec3& corner : out) corner = glm::dvec3(view.view_from_world * glm::dvec4(corner, 1));
  return out;
}

// The largest alpha that 8 bits round to 0.
constexpr float kFaintAlpha = 1.0f / 510;

// A ball of 1/32 of a pixel covers 1/1304 of the pixel; 8 bits round alpha below 1/510 to 0. unit: pixels.
constexpr double kSmallestBall = 1.0 / 32;

// Returns whether the ball around the volume's box is smaller than kSmallestBall in the picture.
bool isTooSmall(const VolumeGeometry& volume, const View& view) {
  const std::array<glm::dvec3, 8> corners = cornersInView(volume, view);
  const glm::dvec3 centre = (corners.front() + corners.back()) * 0.5;
  double radius = 0;
  for (const glm::dvec3& corner : corners) radius = std::max(radius, glm::distance(centre, corner));
  if (view.projection == Projection::kOrthographic) return 2 * radius * view.focal_px < kSmallestBall;
  const bool perspective = view.projection == Projection::kPerspective;
  const double distance = (perspective ? centre.z : glm::length(centre)) - radius;
  return distance > 0 && 2 * radius * view.focal_px < kSmallestBall * distance;
}

// A panorama shows all directions.
std::optional<EmptyFrame> outOfView(const VolumeGeometry& volume, const FrameRequest& request) {
  const View& view = request.view;
  if (view.projection == Projection::kEquirectangular) return std::nullopt;
  const bool perspective = view.projection == Projection::kPerspective;
  const std::array<glm::dvec3, 8> corners = cornersInView(volume, view);
  const auto all = [&](const auto& is_outside) { return std::all_of(corners.begin(), corners.end(), is_outside); };
  if (perspective && all([](const glm::dvec3& p) { return !(p.z > 0); })) return EmptyFrame::kBehind;
  const PixelRect pixels = drawnPixels(view.size, request.crop);
  const double ends[2][2] = {{static_cast<double>(pixels.x0), static_cast<double>(pixels.x1)},
                             {static_cast<double>(pixels.y0), static_cast<double>(pixels.y1)}};
  for (int axis = 0; axis < 2; ++axis) {
    for (const double side : {-1.0, 1.0}) {
      // A pixel's border as a plane through the eye, or along the view.
      const double edge = ends[axis][side < 0 ? 0 : 1] - view.centre_px[axis];
      const auto beyond = [&](const glm::dvec3& p) {
        return side * (view.focal_px * p[axis] - edge * (perspective ? p.z : 1)) > 0;
      };
      if (all(beyond)) return EmptyFrame::kOutOfView;
    }
  }
  return std::nullopt;
}

struct DrawnVolume {
  const TransferFunction& function;
  const Clipping& clipping;
  const Manifest& manifest;
};

std::vector<DrawnVolume> volumesOf(const FrameScene& scene, const std::vector<const Manifest*>& manifests) {
  if (scene.volumes.empty()) return {{scene.transfer_function, scene.picture.clipping, *manifests.front()}};
  std::vector<DrawnVolume> out;
  for (std::size_t i = 0; i < scene.volumes.size(); ++i)
    out.push_back({scene.volumes[i].transfer_function, scene.volumes[i].clipping, *manifests[i]});
  return out;
}

EmptyFrame reasonOf(const DrawnVolume& volume, const FrameRequest& request) {
  const bool composites = request.engine().capabilities().composites;
  const ValueRange& range = volume.manifest.range;
  const VolumeGeometry& geometry = volume.manifest.geometry();
  if (composites && !showsSomeValue(volume.function)) return EmptyFrame::kOpacity;
  if (composites ? !showsSomeOf(volume.function, range) : range.empty()) return EmptyFrame::kValues;
  if (ClipRegion(volume.clipping, geometry).classify(boxOf(geometry.dims)) == ClipRegion::Overlap::kOutside)
    return EmptyFrame::kClipped;
  if (const auto why = outOfView(geometry, request)) return *why;
  return isTooSmall(geometry, request.view) ? EmptyFrame::kTooSmall : EmptyFrame::kCombined;
}

// True where a region, a box of the world or planes cut a volume.
bool isCut(const DrawnVolume& volume) { return !ClipRegion(volume.clipping, volume.manifest.geometry()).showsAll(); }

// A constant function is of one colour on purpose, and gradients make differences of their own.
bool isBeside(const DrawnVolume& volume) {
  const TransferFunction& function = volume.function;
  const ValueRange& range = volume.manifest.range;
  const auto& points = function.points;
  if (!function.labels.empty() || function.usesGradient() || points.empty()) return false;
  const auto differs = [&](const TransferPoint& point) {
    return point.color != points.front().color || point.opacity != points.front().opacity;
  };
  return range.lo < range.hi && std::any_of(points.begin(), points.end(), differs) &&
         (range.hi < points.front().value || range.lo > points.back().value);
}

// requires: the frame is empty.
EmptyFrame reasonForNothing(const FrameScene& scene, const FrameRequest& request,
                            const std::vector<const Manifest*>& manifests) {
  std::optional<EmptyFrame> out;
  for (const DrawnVolume& volume : volumesOf(scene, manifests)) {
    const EmptyFrame why = reasonOf(volume, request);
    out = !out || *out == why ? why : EmptyFrame::kCombined;
  }
  return *out == EmptyFrame::kCombined && scene.masked ? EmptyFrame::kMasked : *out;
}

}  // namespace

// Samples of light fade as the volume becomes smaller than a pixel. Opaque voxels of the voxel lattice may stay
// visible, and a pixel of another mode has one value or none.
EmptyFrame emptinessOf(bool draws, const FrameScene& scene, const FrameRequest& request,
                       const std::vector<const Manifest*>& manifests) {
  if (!draws) return reasonForNothing(scene, request, manifests);
  const auto too_small = [&](const Manifest* volume) { return isTooSmall(volume->geometry(), request.view); };
  const bool fades = request.engine().capabilities().filters_rays;
  return fades && std::all_of(manifests.begin(), manifests.end(), too_small) ? EmptyFrame::kTooSmall
                                                                             : EmptyFrame::kShows;
}

bool isVisible(const Image& image) {
  for (std::size_t alpha = 3; alpha < image.rgba.size(); alpha += 4) {
    if (image.rgba[alpha] > kFaintAlpha) return true;
  }
  return false;
}

bool isOfOneColour(const FrameScene& scene, const std::vector<const Manifest*>& manifests) {
  const std::vector<DrawnVolume> volumes = volumesOf(scene, manifests);
  return std::any_of(volumes.begin(), volumes.end(), isBeside);
}

// Projected voxels may be NaN: visited voxels alone do not make a picture. A part of a picture may be faint where the
// whole is not.
EmptyFrame emptinessOf(const FrameStatistics& drawn, const FrameScene& scene, const FrameRequest& request,
                       const std::vector<const Manifest*>& manifests) {
  const bool composites = request.engine().capabilities().composites, is_part = scene.picture.clipping.part.has_value();
  const EmptyFrame out =
      emptinessOf(composites ? drawn.draws() : drawn.bricks_contributing > 0, scene, request, manifests);
  const bool is_guess = out == EmptyFrame::kCombined || out == EmptyFrame::kMasked;
  if (is_guess && drawn.bricks_damaged > 0) return EmptyFrame::kDamaged;
  if (out != EmptyFrame::kShows || !composites || is_part || drawn.visible) return out;
  const std::vector<DrawnVolume> volumes = volumesOf(scene, manifests);
  return std::any_of(volumes.begin(), volumes.end(), isCut) ? EmptyFrame::kThin : EmptyFrame::kFaint;
}

std::string emptyText(EmptyFrame why) {
  switch (why) {
    case EmptyFrame::kShows:
      break;
    case EmptyFrame::kOpacity:
      return "the transfer function has opacity 0 everywhere";
    case EmptyFrame::kValues:
      return "the transfer function is transparent for all values of the volume (kiln info shows their range)";
    case EmptyFrame::kClipped:
      return "the region, the box of the world or the clip planes leave nothing of the volume";
    case EmptyFrame::kBehind:
      return "the volume is behind the eye: the camera looks away from it";
    case EmptyFrame::kOutOfView:
      return "the volume is beside the picture, or the crop: the camera looks past it";
    case EmptyFrame::kTooSmall:
      return "the volume is far smaller than a pixel: the eye is too far away, or the zoom too small";
    case EmptyFrame::kThin:
      return "the region, the box of the world or the clip planes leave too thin a part of the volume to be seen: "
             "alpha is below 1/510 everywhere";
    case EmptyFrame::kFaint:
      return "the transfer function is too transparent, or what it shows too small, to be seen: alpha is below 1/510 "
             "everywhere";
    case EmptyFrame::kCombined:
      return "what the transfer function shows is clipped away, out of view, or the value of no voxel";
    case EmptyFrame::kMasked:
      return "what the transfer function shows is hidden by the mask, clipped away, out of view, or the value of no "
             "voxel";
    case EmptyFrame::kDamaged:
      return "damaged bricks are missing, and the others show nothing";
  }
  return "something is drawn";
}

void warnOfDoubtfulFrames(const std::vector<FrameStatistics>& frames, bool several, Progress& progress) {
  std::map<std::string, std::vector<int>> doubtful;
  for (const FrameStatistics& frame : frames) {
    if (frame.empty != EmptyFrame::kShows)
      doubtful[fmt::format("empty: {}", emptyText(frame.empty))].push_back(frame.frame);
    else if (frame.one_colour)
      doubtful[fmt::format("of one colour: {}", kOneColourText)].push_back(frame.frame);
  }
  for (auto& [why, numbers] : doubtful) {
    std::sort(numbers.begin(), numbers.end());
    const std::string which = !several ? "the picture is"
                              : numbers.size() == 1
                                  ? fmt::format("frame {} is", numbers.front())
                                  : fmt::format("{} frames ({}) are", numbers.size(), framesText(numbers));
    progress.warn(fmt::format("{} {}", which, why));
  }
}

}  // namespace kiln
