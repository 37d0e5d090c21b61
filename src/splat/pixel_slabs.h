// Which slabs of a zone lie where on one pixel's ray: a slab is where the ray meets its middle. Whoever asks about a
// plane of the lattice asks in the same words, whatever brick or part of the volume lies beside it, so that every slab
// of a pixel is on one side of it.
#pragma once

#include <algorithm>

#include "splat/projector.h"
#include "splat/slab_grid.h"

namespace kiln {

/// Slabs [first, end).
struct SlabSpan {
  int first = 0, end = 0;
  bool empty() const { return first >= end; }
};

class PixelSlabs {
 public:
  /// Along the ray through the centre of pixel (x, y). requires: `zone` outlives this; `projector` is of its level.
  PixelSlabs(const SlabZone& zone, const Projector& projector, int x, int y) : zone_(zone) {
    const glm::dvec2 across((x + 0.5 - projector.centre().x) / projector.focal(),
                            (y + 0.5 - projector.centre().y) / projector.focal());
    for (int axis = 0; axis < 3; ++axis) {
      const glm::dvec4& row = projector.indexRow(axis);
      const double lateral = row.x * across.x + row.y * across.y;
      base_[axis] = projector.perspective() ? row.w : row.w + lateral;
      slope_[axis] = projector.perspective() ? row.z + lateral : row.z;
    }
  }

  /// A place of the ray in the level's index space is base + slope · depth.
  const glm::dvec3& base() const { return base_; }
  const glm::dvec3& slope() const { return slope_; }

  /// Leaves the slabs of `span` whose index coordinate is `at` or more (`above`), or less.
  void cut(int axis, double at, bool above, SlabSpan& span) const {
    if (slope_[axis] == 0) {
      if ((base_[axis] >= at) != above) span.end = span.first;
      return;
    }
    const int slab = zone_.slabFrom((at - base_[axis]) / slope_[axis]);
    if ((slope_[axis] > 0) == above)
      span.first = std::max(span.first, slab);
    else
      span.end = std::min(span.end, slab);
  }

 private:
  const SlabZone& zone_;
  glm::dvec3 base_, slope_;
};

}  // namespace kiln
