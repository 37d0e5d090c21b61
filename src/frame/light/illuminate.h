// Draws the shadow maps of a frame's lights, and makes the grid of its ambient occlusion.
// Method. The views of the plan (frame/light/light_plan.h) are drawn one after another. A light that does not move with
// the camera has equal maps in all frames of a sequence.
#pragma once

#include <memory>

#include "base/progress.h"
#include "cache/brick_cache.h"
#include "engine/shared/illumination.h"
#include "frame/pass/frame_request.h"
#include "frame/pass/frame_statistics.h"

namespace kiln {

/// Returns the parts of an earlier illumination that are right for a preview, without drawing. A light without a map
/// casts no shadow. Levels and interpolation may differ. `earlier` may be null.
std::shared_ptr<const Illumination> knownIllumination(const FrameRequest& request, const Illumination* earlier);

/// Gives the request the shadow maps of its lights and its ambient occlusion, unless the request has them. Keeps the
/// parts of the last illumination that are right, and frees the others before drawing. Reports each part as a step of
/// its own. Adds the cost to `statistics`. throws: as renderFrame; the last illumination has the finished parts.
void illuminate(BrickCache& cache, Progress& progress, FrameRequest& request, FrameStatistics& statistics);

}  // namespace kiln
