// Which samples of a unit may reach a tile in a zone of slabs: a box of them. Where a voxel is many samples, as beside
// the eye, most of a unit is elsewhere.
#pragma once

#include <array>
#include <glm/vec3.hpp>

#include "base/pixel_rect.h"
#include "splat/refine_unit.h"

namespace kiln {

class SampleWindow {
 public:
  /// For all lattices of a zone, of which `lattice` is one. `sample_reach`: SlabFrame's. requires: `lattice` outlives
  /// this.
  SampleWindow(const UnitLattice& lattice, double sample_reach, const PixelRect& tile);
  /// Leaves of the samples [first, end) of `unit` no fewer than those that reach the tile; false where none does.
  bool narrow(UnitInput& unit) const;

 private:
  // Half of view space: along · p + beyond >= 0.
  struct Half {
    glm::dvec3 along;
    double beyond;
  };
  bool narrow(UnitInput& unit, const Half& half) const;

  const UnitLattice& l_;
  std::array<Half, 6> halves_;
};

}  // namespace kiln
