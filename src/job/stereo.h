// Stereo pairs. Both eyes look in parallel. Their pictures are shifted so that points at the distance of convergence
// have equal places in both. Without toe-in, heights are equal, too.
#pragma once

#include <filesystem>
#include <optional>

#include "scene/camera/camera_spec.h"

namespace kiln {

inline bool drawsBothEyes(const std::optional<Stereo>& stereo) { return stereo && stereo->eye == StereoEye::kBoth; }

/// Returns the view of the camera, or of the eye that `stereo` selects; for both eyes, the view of the middle. throws:
/// as resolve; Error kUsage for a camera without perspective, because depth then shifts nothing.
View resolve(const Camera& camera, const std::optional<Stereo>& stereo, const ImageSize& size);

/// Returns whether the path has a place for the name of an eye: "%V", or "%v" for its first letter. An existing folder
/// has none.
bool hasEyePlace(const std::filesystem::path& pattern);
/// Returns the path with "left" or "right" (or "l", "r") in each place for an eye. requires: one eye.
std::filesystem::path pathOfEye(const std::filesystem::path& pattern, StereoEye eye);

}  // namespace kiln
