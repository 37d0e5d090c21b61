// Finds the reason for an empty frame, or of one colour, and warns: either is legal, but seldom wanted.
#pragma once

#include <string>
#include <vector>

#include "base/progress.h"
#include "frame/render_frame.h"
#include "frame/statistics.h"
#include "job/frame/frame_scene.h"

namespace kiln {

/// Returns whether 8 bits round the alpha of some pixel above 0. requires: an image without a background.
bool isVisible(const Image& image);

/// Returns whether all values of a volume lie beside a transfer function of several colours or opacities.
bool isOfOneColour(const FrameScene& scene, const std::vector<const Manifest*>& manifests);

/// Returns the reason for an empty frame; kShows if visible samples were drawn. `request` is made of `scene`;
/// `manifests` are of the scene's volumes.
EmptyFrame emptinessOf(const FrameStatistics& drawn, const FrameScene& scene, const FrameRequest& request,
                       const std::vector<const Manifest*>& manifests);
/// Returns the reason for an empty frame from scene and manifests alone; `draws` if bricks are in view.
EmptyFrame emptinessOf(bool draws, const FrameScene& scene, const FrameRequest& request,
                       const std::vector<const Manifest*>& manifests);

/// "the eye looks away from the volume: …". requires: not kShows.
std::string emptyText(EmptyFrame why);

/// "all values of a volume lie beside …".
inline constexpr const char* kOneColourText =
    "all values of a volume lie beside its transfer function or window, and have the colour at the end of these (kiln "
    "info shows the range of values)";

/// Warns once per reason, with the numbers of the empty frames if there are `several` frames. Also warns of frames of
/// one colour.
void warnOfDoubtfulFrames(const std::vector<FrameStatistics>& frames, bool several, Progress& progress);

}  // namespace kiln
