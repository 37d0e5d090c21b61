// One eye of a pair, or both: they look in parallel, and their pictures are shifted so that what is at the distance of
// convergence has the same place in both. Nothing is turned in, so that no height differs.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

#include "scene/camera/camera.h"

namespace kiln {

enum class StereoEye { kLeft, kRight, kBoth };

struct Stereo {
  StereoEye eye = StereoEye::kLeft;
  double interocular = 0;             // between both eyes. unit: world
  std::optional<double> convergence;  // depth; else the target's distance from the eye. unit: world
  bool operator==(const Stereo&) const = default;
};

inline bool drawsBothEyes(const std::optional<Stereo>& stereo) { return stereo && stereo->eye == StereoEye::kBoth; }

/// The view of the camera, or where `stereo` is given, of that eye of a pair of which the camera is the middle; of both
/// eyes, the middle's. throws: as resolve; Error kUsage for a camera that is not a perspective one, in which depth
/// shifts nothing.
View resolve(const Camera& camera, const std::optional<Stereo>& stereo, const ImageSize& size);

/// Returns whether the path has a place for the name of an eye: "%V", or "%v" for its first letter.
bool hasEyePlace(const std::filesystem::path& pattern);
/// The path with "left" or "right" (or "l", "r") in each such place. requires: one eye.
std::filesystem::path pathOfEye(const std::filesystem::path& pattern, StereoEye eye);

}  // namespace kiln
