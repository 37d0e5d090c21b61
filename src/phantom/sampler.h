// Samples a figure on a voxel lattice: a voxel's value is the mean of its tissues, weighted by coverage, plus noise.
// Invariant. The bits of a voxel depend only on its coordinates, the lattice, the tables and the seed. Work is cut into
// blocks at multiples of 8 voxels, whatever box is requested, and every decision for a block is a function of its
// position.
#pragma once

#include <glm/vec3.hpp>

#include "grid/coords.h"
#include "phantom/models/figure.h"
#include "phantom/models/tissue.h"

namespace kiln::phantom {

/// The voxel lattice: voxel i spans [i, i+1) · spacing from `corner` along each axis.
struct Lattice {
  Extent3 dims;
  glm::dvec3 corner_mm{0}, spacing_mm{1};
  glm::vec3 centreOf(const VoxelCoord& v) const;
  /// Distance over which two tissues blend, about one voxel. unit: mm.
  float blurMm() const { return static_cast<float>((spacing_mm.x + spacing_mm.y + spacing_mm.z) / 3); }
};

class Sampler {
 public:
  /// requires: `figure` and `values` outlive the sampler.
  Sampler(const Figure& figure, const Lattice& lattice, const ValueTable& values, std::uint64_t seed)
      : figure_(figure), lattice_(lattice), values_(values), seed_(seed) {}

  /// Fills `out` with the voxels of `box`. shape: x fastest, then y, then z, densely packed. T: std::uint8_t or
  /// std::uint16_t. requires: box inside the lattice. thread: safe.
  template <class T>
  void sample(const VoxelBox& box, T* out) const;

 private:
  const Figure& figure_;
  Lattice lattice_;
  const ValueTable& values_;
  std::uint64_t seed_;
};

}  // namespace kiln::phantom
