#include "engine/pixel/ray_sampling.h"

#include <algorithm>
#include <cmath>

namespace kiln {

RaySampling::RaySampling(const std::vector<SlabZone>& zones, std::size_t i, const Projector& projector,
                         const Extent3& dims, const EndVoxels& ends, bool in_quincunx)
    : quincunx(in_quincunx) {
  const SlabZone& zone = zones[i];
  end = zone.slabs;
  const int middle_slab = zone.slabs / 2;
  const double depth = zone.near + (middle_slab + 0.5) * zone.thickness, per_pixel = 1 / projector.focal();
  middle = static_cast<float>(middle_slab);
  centre_x = static_cast<float>(0.5 - projector.centre().x);
  centre_y = static_cast<float>(0.5 - projector.centre().y);
  anchor = anchorOf(dims);
  for (int axis = 0; axis < 3; ++axis) {
    const auto from = static_cast<double>(anchor[axis]);
    const glm::dvec4& row = projector.indexRow(axis);
    // A view-space point of the ray is (u depth, v depth, depth) in perspective, otherwise (u, v, depth).
    const auto setAt = [&](double of, Linear& out) {
      const double widened = projector.perspective() ? of : 1;
      out.centre[axis] = static_cast<float>(row.w + row.z * of - from);
      out.along_x[axis] = static_cast<float>(row.x * widened * per_pixel);
      out.along_y[axis] = static_cast<float>(row.y * widened * per_pixel);
    };
    setAt(depth, place), setAt(zone.near, at_begin), setAt(zone.far, at_end);
    const double of_step = projector.perspective() ? zone.thickness : 0;
    step.centre[axis] = static_cast<float>(row.z * zone.thickness);
    step.along_x[axis] = static_cast<float>(row.x * of_step * per_pixel);
    step.along_y[axis] = static_cast<float>(row.y * of_step * per_pixel);
    volume_hi[axis] = static_cast<double>(dims[axis]) - 1.5 + ends.part[axis];
    faces_from[axis] = projector.perspective() ? row.w : from;
  }
  eye = static_cast<float>(-depth / zone.thickness);
  if (projector.perspective()) first = zone.slabFrom(projector.nearDepth());
  if (zone.behind_finer && first == 0) overlap = SlabZone::kOverlap;
  const auto beside = [&](const SlabZone& other) { return static_cast<float>(0.5 * other.thickness / zone.thickness); };
  before = static_cast<float>(first) - 1 - middle, after = static_cast<float>(end) - middle;
  if (i > 0 && first == 0) before += 0.5f - beside(zones[i - 1]);
  if (i + 1 < zones.size()) after += beside(zones[i + 1]) - 0.5f;
}

float RaySampling::longestStep(const PixelRect& pixels) const {
  float out = 0;
  for (const int x : {pixels.x0, pixels.x1}) {
    for (const int y : {pixels.y0, pixels.y1}) {
      const glm::vec3 here = step.centre + (static_cast<float>(x) + centre_x) * step.along_x +
                             (static_cast<float>(y) + centre_y) * step.along_y;
      for (int a = 0; a < 3; ++a) out = std::max(out, std::abs(here[a]));
    }
  }
  return out;
}

}  // namespace kiln
