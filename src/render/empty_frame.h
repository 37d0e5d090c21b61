// Finds the reason for an empty frame, and warns: an empty frame is legal, but seldom wanted.
#pragma once

#include <string>
#include <vector>

#include "base/progress.h"
#include "render/render_frame.h"
#include "render/statistics.h"
#include "scene/frame_scene.h"

namespace kiln {

/// Returns the reason for an empty frame; kShows if visible samples were drawn. `request` is made of `scene`;
/// `manifests` are of the scene's volumes.
EmptyFrame emptinessOf(const FrameStatistics& drawn, const FrameScene& scene, const FrameRequest& request,
                       const std::vector<const Manifest*>& manifests);
/// Returns the reason for an empty frame from scene and manifests alone; `draws` if bricks are in view.
EmptyFrame emptinessOf(bool draws, const FrameScene& scene, const FrameRequest& request,
                       const std::vector<const Manifest*>& manifests);

/// "the eye looks away from the volume: …". requires: not kShows.
std::string emptyText(EmptyFrame why);

/// Warns once for each reason; if there are `several` frames, with the numbers of the empty frames.
void warnOfEmptyFrames(const std::vector<FrameStatistics>& frames, bool several, Progress& progress);

}  // namespace kiln
