#include "engine/pixel/cut_faces.h"

#include <algorithm>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "scene/half_spaces.h"
#include "scene/transfer/display_map.h"

namespace kiln {

CutFaces::CutFaces(const Section& section, const Manifest& volume, const FrameLevels& levels, const SampleTable& own)
    : opacity_(static_cast<float>(section.opacity)) {
  const Projector& projector = levels.projector(levels.finest());
  perspective_ = projector.perspective();
  per_pixel_ = 1 / projector.focal();
  centre_px_ = projector.centre();
  near_depth_ = perspective_ ? projector.nearDepth() : -kNone;
  for (const glm::dvec4& face : levels.clipRegion(levels.finest()).halfSpaces()) {
    if (!cuts(face, levels.dims(levels.finest()))) {
      seen_.push_back(false);
      continue;
    }
    glm::dvec4 in_view(0, 0, 0, face.w);
    for (int axis = 0; axis < 3; ++axis) in_view += face[axis] * projector.indexRow(axis);
    planes_.push_back(in_view);
    // A face looks at the eye if the eye is on its hidden side.
    seen_.push_back(perspective_ ? in_view.w < 0 : in_view.z > 0);
  }
  if (section.color_map.empty()) return;
  colors_.emplace(functionOf(section), own.unit(), volume.type, volume.range);
  shift_ = static_cast<float>(own.offset() - colors_->offset());
}

double CutFaces::depthAt(int x, int y) const noexcept {
  const double u = (x + 0.5 - centre_px_.x) * per_pixel_, v = (y + 0.5 - centre_px_.y) * per_pixel_;
  double enter = near_depth_, leave = kNone;
  for (const glm::dvec4& plane : planes_) {
    // A view-space point of the ray is (u depth, v depth, depth) in perspective, otherwise (u, v, depth).
    const double across = plane.x * u + plane.y * v;
    const double slope = perspective_ ? across + plane.z : plane.z, at_zero = perspective_ ? plane.w : across + plane.w;
    if (slope > 0) enter = std::max(enter, -at_zero / slope);
    if (slope < 0) leave = std::min(leave, -at_zero / slope);
    if (slope == 0 && at_zero < 0) return kNone;
  }
  return enter > near_depth_ && enter < leave ? enter : kNone;
}

std::vector<glm::dvec4> CutFaces::seenFaces(const ClipRegion& level) const {
  std::vector<glm::dvec4> out = level.halfSpaces();
  std::size_t i = 0;
  std::erase_if(out, [&](const glm::dvec4&) { return !seen_[i++]; });
  return out;
}

std::unique_ptr<const CutFaces> cutFacesOf(const Section* section, const Manifest& volume, const FrameLevels& levels,
                                           const SampleTable& own) {
  if (section == nullptr) return nullptr;
  auto out = std::make_unique<const CutFaces>(*section, volume, levels, own);
  return out->seenFaces(levels.clipRegion(levels.finest())).empty() ? nullptr : std::move(out);
}

}  // namespace kiln
