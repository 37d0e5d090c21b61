#include "engine/shared/view_box.h"

#include <algorithm>
#include <glm/common.hpp>

namespace kiln {
namespace {

// Bounding rectangle of projected points. The picture's centre is added at the end, since all points share the offset.
class Seen {
 public:
  explicit Seen(const Projector& projector) : focal_(projector.focal()), centre_(projector.centre()) {}
  void include(const glm::dvec3& p) {
    const double scale = focal_ / p.z, x = scale * p.x, y = scale * p.y;
    out_.x0 = std::min(out_.x0, x), out_.x1 = std::max(out_.x1, x);
    out_.y0 = std::min(out_.y0, y), out_.y1 = std::max(out_.y1, y);
  }
  ViewExtent all() const {
    return {out_.x0 + centre_.x, out_.y0 + centre_.y, out_.x1 + centre_.x, out_.y1 + centre_.y};
  }

 private:
  const double focal_;
  const glm::dvec2 centre_;
  ViewExtent out_;
};

}  // namespace

ViewBox::ViewBox(const Projector& projector, const VoxelBox& box)
    : corner(projector.viewOfIndex({static_cast<double>(box.lo.x) - 0.5, static_cast<double>(box.lo.y) - 0.5,
                                    static_cast<double>(box.lo.z) - 0.5})),
      edge{static_cast<double>(box.hi.x - box.lo.x) * projector.axis(0),
           static_cast<double>(box.hi.y - box.lo.y) * projector.axis(1),
           static_cast<double>(box.hi.z - box.lo.z) * projector.axis(2)},
      projector_(projector) {
  nearest = corner.z + std::min(edge[0].z, 0.0) + std::min(edge[1].z, 0.0) + std::min(edge[2].z, 0.0);
  farthest = corner.z + std::max(edge[0].z, 0.0) + std::max(edge[1].z, 0.0) + std::max(edge[2].z, 0.0);
}

ViewExtent ViewBox::extent() const {
  if (!projector_.perspective()) {
    const glm::dvec3 half = 0.5 * (glm::abs(edge[0]) + glm::abs(edge[1]) + glm::abs(edge[2]));
    const glm::dvec2 px = projector_.pixelOf(corner + 0.5 * (edge[0] + edge[1] + edge[2]));
    const double x = projector_.focal() * half.x, y = projector_.focal() * half.y;
    return {px.x - x, px.y - y, px.x + x, px.y + y};
  }
  Seen seen(projector_);
  for (const glm::dvec3& p : {corner, corner + edge[1], corner + edge[2], corner + (edge[1] + edge[2])})
    seen.include(p), seen.include(p + edge[0]);
  return seen.all();
}

// Clips the box's twelve edges against both depth planes: the corners of the clipped box lie on the box's edges.
ViewExtent ViewBox::extentBetween(double near, double far) const {
  Seen seen(projector_);
  for (int axis = 0; axis < 3; ++axis) {
    const glm::dvec3 &u = edge[(axis + 1) % 3], &v = edge[(axis + 2) % 3];
    for (const glm::dvec3& p : {corner, corner + u, corner + v, corner + (u + v)}) {
      const glm::dvec3 q = p + edge[axis];
      const glm::dvec3 &a = p.z <= q.z ? p : q, &b = p.z <= q.z ? q : p;
      if (b.z < near || a.z > far) continue;
      const auto at = [&](double z) { return a + (z - a.z) / (b.z - a.z) * (b - a); };
      seen.include(a.z < near ? at(near) : a);
      seen.include(b.z > far ? at(far) : b);
    }
  }
  return seen.all();
}

}  // namespace kiln
