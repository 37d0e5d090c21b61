// Draws the shadow maps of a frame's lights, and makes the grid of its ambient occlusion.
// Method. A light's view is drawn as a frame is, by the same pass and engine, with the same culling and cache; only
// opacity is kept. A light that does not move with the camera has equal maps in all frames of a sequence.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "base/progress.h"
#include "cache/brick_cache.h"
#include "engine/shared/illumination.h"
#include "frame/pass/frame_request.h"
#include "frame/pass/frame_statistics.h"
#include "scene/clipping.h"
#include "store/bricked_volume.h"

namespace kiln {

/// Largest edge of a shadow map by default. unit: pixels.
inline constexpr int kShadowEdge = 1024;

/// Returns the memory for a shading's shadow maps and ambient occlusion, with the memory for drawing one of them.
/// `clippings`: of the volumes. unit: bytes.
std::uint64_t illuminationBytes(const std::vector<const BrickedVolume*>& volumes,
                                const std::vector<Clipping>& clippings, const Shading& shading,
                                const ImageSize& picture);

/// Returns the requests whose drawings fill the lattice for ambient occlusion: one, or three along different axes if
/// there are surfaces.
std::vector<FrameRequest> latticeRequests(const std::vector<const BrickedVolume*>& volumes,
                                          const FrameRequest& request);

/// Returns the requests whose drawings make the shadow maps and the ambient occlusion of a frame.
std::vector<FrameRequest> lightRequests(const std::vector<const BrickedVolume*>& volumes, const FrameRequest& request);

/// Returns the parts of an earlier illumination that are right for a preview, without drawing. A light without a map
/// casts no shadow. Levels and interpolation may differ. `earlier` may be null.
std::shared_ptr<const Illumination> knownIllumination(const FrameRequest& request, const Illumination* earlier);

/// Gives the request the shadow maps of its lights and its ambient occlusion, unless the request has them. The parts of
/// the last illumination that are right are kept. Reports each part as a step of its own. Adds the cost to
/// `statistics`. throws: as renderFrame.
void illuminate(BrickCache& cache, Progress& progress, FrameRequest& request, FrameStatistics& statistics);

}  // namespace kiln
