// The plan of a frame's light: views and requests of shadow maps and of ambient occlusion, and their memory.
// Method. A light's view is drawn as a frame is, by the same pass and engine, with the same culling and cache; only
// opacity is kept.
// Invariant. Views depend on the light, the volumes and the size of the picture, never on the picture's crop.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "engine/shared/illumination.h"
#include "frame/light/gather_ambient.h"
#include "frame/light/shadow_views.h"
#include "frame/pass/frame_request.h"
#include "scene/clipping.h"
#include "store/bricked_volume.h"

namespace kiln {

/// Largest edge of a shadow map by default. unit: pixels.
inline constexpr int kShadowEdge = 1024;
/// Rows of a light's view drawn at a time, which bounds the memory of the pixels. unit: pixels.
inline constexpr int kOpacityBand = 256;

/// The extent of all volumes after their regions.
struct ShownExtent {
  std::vector<glm::dvec3> corners;
  double voxel = 0;          // smallest mean edge of a voxel. unit: world
  std::int64_t longest = 0;  // edge of a volume. unit: voxels
};
ShownExtent shownExtentOf(const std::vector<const BrickedVolume*>& volumes, const std::vector<Clipping>& clippings);

/// Returns everything but the lights that the shadows of a frame depend on.
ShadowScene shadowSceneOf(const FrameRequest& request);

/// Returns whether samples of the picture reflect or scatter light.
bool isIlluminated(const FrameRequest& request);

/// Returns the longest edge of a light's shadow maps. unit: pixels.
int shadowEdgeOf(const Light& light, const ShownExtent& extent, const ImageSize& picture);

/// Returns the views of the shadow maps of a light, for each of its points. requires: corners.
std::vector<std::vector<ShadowView>> shadowMapViews(const Light& light, const View& eye, const ShownExtent& extent,
                                                    int edge_px);

/// Returns the request whose drawing has the opacities of a view only.
FrameRequest opacityRequest(FrameRequest request, const View& view);

/// Returns the lattice for ambient occlusion, seen along the z axis of the first volume.
LatticeView ambientLattice(const VolumeGeometry& first, const ShownExtent& extent);

/// Returns the distance beyond which matter does not occlude, at most the diagonal of all volumes. unit: world.
double ambientRadius(const AmbientOcclusion& occlusion, const ShownExtent& extent);

/// Returns the memory for a shading's shadow maps and ambient occlusion, with the memory for drawing one of them.
/// `clippings`: of the volumes. `lights_move`: places of lights differ from frame to frame. unit: bytes.
std::uint64_t illuminationBytes(const std::vector<const BrickedVolume*>& volumes,
                                const std::vector<Clipping>& clippings, const Shading& shading, bool lights_move,
                                const ImageSize& picture);

/// Returns the requests whose drawings fill the lattice for ambient occlusion: one, or three along different axes if
/// there are surfaces.
std::vector<FrameRequest> latticeRequests(const std::vector<const BrickedVolume*>& volumes,
                                          const FrameRequest& request);

/// Returns the requests whose drawings make the shadow maps and the ambient occlusion of a frame.
std::vector<FrameRequest> lightRequests(const std::vector<const BrickedVolume*>& volumes, const FrameRequest& request);

}  // namespace kiln
