// Cut faces: where rays enter the visible part of a volume through a face of its clipping, and the colours of the
// values there. Problem. A ray's point on a face must be in exactly one cell of one zone, whatever the bricks, and have
// equal bits. Method. The point follows from the view alone: the region is convex, so that a ray enters it where it is
// behind all faces that look at the eye. The depth is computed in double precision, in view space, from the finest
// level. Invariant. In front of the point the volume shows nothing: the point is the first sample of its ray.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "engine/pixel/voxels/sample_table.h"
#include "scene/clip_region.h"
#include "scene/clipping.h"
#include "traverse/frame_levels.h"

namespace kiln {

class CutFaces {
 public:
  static constexpr double kNone = std::numeric_limits<double>::infinity();

  /// requires: a window, if the section has a colour map; `own` is the volume's table and outlives this.
  CutFaces(const Section& section, const Manifest& volume, const FrameLevels& levels, const SampleTable& own);

  /// Depth at which the ray of a pixel enters the region through a face; kNone if there is no such face. unit: world.
  double depthAt(int x, int y) const noexcept;

  /// Returns the faces that look at the eye, in the index space of a level: half-spaces as ClipRegion::halfSpaces.
  std::vector<glm::dvec4> seenFaces(const ClipRegion& level) const;

  float opacity() const { return opacity_; }
  /// Colours of the values on faces; null: those of the volume's own table, where its extinction is above 0.
  const SampleTable* colors() const { return colors_ ? &*colors_ : nullptr; }
  /// Added to a value less the offset of the volume's table, as `colors` has its own offset.
  float shift() const { return shift_; }

 private:
  std::vector<glm::dvec4> planes_;  // those that cut the volume, in view space
  std::vector<bool> seen_;          // of each half-space of the region: it cuts the volume and looks at the eye
  bool perspective_;
  double per_pixel_, near_depth_;
  glm::dvec2 centre_px_;
  float opacity_, shift_ = 0;
  std::optional<SampleTable> colors_;
};

/// Returns the cut faces of a volume; null without a section or without faces that look at the eye. requires: as
/// CutFaces.
std::unique_ptr<const CutFaces> cutFacesOf(const Section* section, const Manifest& volume, const FrameLevels& levels,
                                           const SampleTable& own);

}  // namespace kiln
