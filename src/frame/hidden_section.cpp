#include "frame/hidden_section.h"

#include <fmt/format.h>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <optional>

#include "base/error.h"
#include "grid/point_bounds.h"
#include "job/job_names.h"
#include "scene/camera/framing.h"
#include "scene/clip_region.h"
#include "scene/half_spaces.h"

namespace kiln {
namespace {

// Returns the half-spaces of the world that hide a part of the volume.
std::vector<glm::dvec4> cutsOf(const Clipping& clipping, const VolumeGeometry& geometry) {
  const glm::dmat4 index_from_world = glm::inverse(geometry.world_from_index);
  std::vector<glm::dvec4> out;
  for (const glm::dvec4& half_space : ClipRegion(clipping, geometry).halfSpaces()) {
    if (cuts(half_space, geometry.dims)) out.push_back(half_space * index_from_world);
  }
  return out;
}

// A face looks at the eye if the eye is on its hidden side.
bool looksAtEye(const glm::dvec4& cut, const View& view) {
  if (view.projection == Projection::kOrthographic) return glm::dot(glm::dvec3(cut), view.forward_world) > 0;
  return glm::dot(cut, glm::dvec4(view.eye_world, 1)) < 0;
}

// Returns the side whose eye looks most squarely at the face of the cut.
std::string_view sideOf(const glm::dvec4& cut, PatientFrame frame) {
  Side out = Side::kFront;
  for (std::size_t i = 0; i < kSides; ++i) {
    const Side side{static_cast<int>(i)};
    if (glm::dot(glm::dvec3(cut), towardsEye(frame, side)) < glm::dot(glm::dvec3(cut), towardsEye(frame, out)))
      out = side;
  }
  return kSideNames[static_cast<std::size_t>(out)];
}

// Returns the plane with the opposite sign, if it is the only one. A plane of one of several volumes has no option.
std::string oppositeText(const FrameScene& scene) {
  const Clipping& clipping = scene.picture.clipping;
  if (!scene.volumes.empty() || clipping.region || clipping.planes.size() != 1) return "";
  const glm::dvec3 normal = 0.0 - clipping.planes.front().normal;
  return fmt::format(", or keep the other side (--clip {},{},{},{})", normal.x, normal.y, normal.z,
                     0.0 - clipping.planes.front().offset);
}

// Returns the warning of planes beside the only volume of a scene.
std::string besideText(const VolumeGeometry& geometry) {
  PointBounds box;
  for (const glm::dvec3& corner : geometry.corners()) box.add(corner);
  return fmt::format(
      "--section: no clip plane and no region cuts the volume, so the picture shows no section; move them into the "
      "volume, which has x from {:.6g} to {:.6g}, y from {:.6g} to {:.6g} and z from {:.6g} to {:.6g}",
      box.lo.x, box.hi.x, box.lo.y, box.hi.y, box.lo.z, box.hi.z);
}

}  // namespace

std::string hiddenSectionText(const SceneOfJob& scenes, const std::vector<int>& frames, std::size_t volume,
                              const VolumeGeometry& geometry) {
  std::string out;
  bool beside = false;  // frames have a section, and nothing cuts the only volume
  for (const int frame : frames) {
    try {
      const FrameScene scene = scenes.at(frame);
      const Clipping& clipping = scene.volumes.empty() ? scene.picture.clipping : scene.volumes[volume].clipping;
      if (!clipping.section) return "";
      const View view = resolve(scene.camera, scene.picture.size);
      const std::vector<glm::dvec4> found = cutsOf(clipping, geometry);
      beside = beside || (found.empty() && scene.volumes.empty());
      for (const glm::dvec4& cut : found) {
        if (looksAtEye(cut, view)) return "";
        if (!out.empty()) continue;
        out = fmt::format(
            "--section: no cut face looks at the camera, so the picture shows nothing of the section; look from the "
            "side that is cut away (--view {}{}){}",
            sideOf(cut, scene.box.frame), scene.picture.camera.framed() ? "" : ", without --eye", oppositeText(scene));
      }
    } catch (const Error&) {
      // Drawing the frame reports the error, with the frame's number.
    }
  }
  return out.empty() && beside ? besideText(geometry) : out;
}

}  // namespace kiln
