// A figure on a lattice of voxels: the value of each is that of its tissues by the share that each covers, and noise.
// Invariant: a voxel's bits depend on its coordinates, the lattice, the tables and the seed, and on nothing else: the
// work is cut into blocks at multiples of 8 voxels, whatever box was asked for, and all that is decided for a block is
// a function of its place.
#pragma once

#include <glm/vec3.hpp>

#include "grid/coords.h"
#include "phantom/models/figure.h"
#include "phantom/models/tissue.h"

namespace kiln::phantom {

/// Where the voxels are: voxel i spans [i, i+1) · spacing from `corner`, along each axis.
struct Lattice {
  Extent3 dims;
  glm::dvec3 corner_mm{0}, spacing_mm{1};
  glm::vec3 centreOf(const VoxelCoord& v) const;
  /// Over how much distance two tissues blend: about one voxel. unit: mm.
  float blurMm() const { return static_cast<float>((spacing_mm.x + spacing_mm.y + spacing_mm.z) / 3); }
};

class Sampler {
 public:
  /// `figure` and `values` must live as long as the sampler.
  Sampler(const Figure& figure, const Lattice& lattice, const ValueTable& values, std::uint64_t seed)
      : figure_(figure), lattice_(lattice), values_(values), seed_(seed) {}

  /// Fills `out` with the voxels of `box`. shape: x fastest, then y, then z, densely packed. T: std::uint8_t or
  /// std::uint16_t. requires: box inside the lattice. thread: any number at once.
  template <class T>
  void sample(const VoxelBox& box, T* out) const;

 private:
  const Figure& figure_;
  Lattice lattice_;
  const ValueTable& values_;
  std::uint64_t seed_;
};

}  // namespace kiln::phantom
