// Outline of what projections show: the volume's box, cut by the clip region, as a convex polygon of the picture.
// Problem. A pixel has one ray, which hits or misses the box: the box's border would have stairs.
// Method. A pixel is as opaque as the share of its square inside the polygon. Its ray passes through the middle
// (centroid) of the covered part, hence through the box, even where the box misses the pixel's centre.
// Invariant. Share and middle depend on the view and the clip region alone, never on crops, tiles, bricks or levels.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <vector>

#include "engine/shared/projector.h"
#include "scene/clip_region.h"

namespace kiln {

class Silhouette {
 public:
  /// Outlines the box from -1/2 to `end` in the index space of the projector and the region.
  Silhouette(const Projector& projector, const ClipRegion& clip, const glm::dvec3& end);

  /// A pixel's covered part. unit: the picture's pixels.
  struct Part {
    double share = 0;  // 0: nothing is covered; exactly 1: everything is
    glm::dvec2 middle{0};
  };
  /// The pixels of a row.
  class Row {
   public:
    Part at(int x) const;

   private:
    friend class Silhouette;
    const Silhouette* outline_ = nullptr;
    int y_ = 0;
    int first_ = 0, end_ = 0;              // all other pixels are uncovered
    int whole_first_ = 0, whole_end_ = 0;  // pixels that are covered entirely
  };
  Row row(int y) const;

 private:
  struct Span {
    double lo, hi;
    bool empty() const { return !(lo <= hi); }
  };
  /// Returns the columns on the line at `y`.
  Span columnsAt(double y) const;
  Part partOf(int x, int y) const;

  std::vector<glm::dvec2> corners_;  // convex; empty if nothing is shown
};

}  // namespace kiln
