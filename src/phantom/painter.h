// Which shapes matter to a block of 8³ voxels, and what the block's voxels are without noise. An internal header of the
// sampler's.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "phantom/sampler.h"

namespace kiln::phantom {

inline constexpr int kEdge = 8;
inline constexpr int kBlockVoxels = kEdge * kEdge * kEdge;

// Between what bounds a distance is at all voxel centres of a box; a little wider than rounding. unit: mm.
struct Bounds {
  float lo, hi;
};

// The shapes that matter somewhere, part by part from the highest precedence down.
struct NearShape {
  std::uint32_t index;  // in the figure
  Bounds distance;
};
struct NearPart {
  PartId part;
  std::size_t first, count;  // in `shapes`
};
struct NearShapes {
  std::vector<NearPart> parts;
  std::vector<NearShape> shapes;
  void clear() {
    parts.clear();
    shapes.clear();
  }
};

// The ball around a block's voxel centres, and the half edges of the box around them. unit: mm.
struct Ball {
  float centre[3], half[3], radius;
};

// What one thread needs to paint one block: the coordinates of its voxels, and a number for each of them.
struct Work {
  float x[kEdge], y[kEdge], z[kEdge];
  int lo_y, hi_y, lo_z, hi_z;  // rows asked for
  alignas(64) float d[kBlockVoxels];
  alignas(64) float outer[kBlockVoxels];
  alignas(64) float inner[kBlockVoxels];
  alignas(64) float value[kBlockVoxels];
  alignas(64) float left[kBlockVoxels];  // the share of the voxel not yet given to a tissue
  bool blank;                            // nothing was given yet, and `value` and `left` are not set

  // Calls f(offset) for each row asked for.
  template <class F>
  void rows(F&& f) {
    for (int k = lo_z; k < hi_z; ++k) {
      for (int j = lo_y; j < hi_y; ++j) f((k * kEdge + j) * kEdge);
    }
  }
  // Calls f(offset) for each number of them, many at a time where f is simple.
  template <class F>
  void each(F&& f) {
    if (lo_y == 0 && hi_y == kEdge && lo_z == 0 && hi_z == kEdge) {
      for (int i = 0; i < kBlockVoxels; ++i) f(i);
      return;
    }
    rows([&](int at) {
      for (int i = at; i < at + kEdge; ++i) f(i);
    });
  }
};

class Painter {
 public:
  Painter(const Figure& figure, const Lattice& lattice, const ValueTable& values)
      : figure_(figure), lattice_(lattice), values_(values), blur_(lattice.blurMm()), inverse_blur_(1 / blur_) {}

  // The shapes in reach of the box, by the boxes around them, without bounds.
  void choose(const VoxelBox& box, NearShapes& out) const;
  // Of the shapes in `from`, those near the box. requires: `from` was chosen for a box around this one; where that was
  // for its bounds, too, for one of this one's proportions.
  void choose(const VoxelBox& box, const NearShapes& from, NearShapes& out) const;
  // Clean values of the block that `near` was chosen for: the one that all of its voxels have, else in work.value.
  std::optional<float> paint(const NearShapes& near, Work& work) const noexcept;

 private:
  Ball ballAround(const VoxelBox& box) const;
  bool isInReach(std::size_t shape, const Ball& ball) const;
  // The bounds of the distance where the shape is near.
  std::optional<Bounds> boundsIfNear(std::size_t shape, const Ball& ball) const;
  // The tissue that takes all that is left, where there is one.
  std::optional<Tissue> paintPart(const NearShapes& near, const NearPart& chosen, Work& work) const noexcept;
  void computeSurfaces(const Part& part, std::span<const NearShape> near, bool inner, Work& work) const noexcept;

  const Figure& figure_;
  const Lattice& lattice_;
  const ValueTable& values_;
  float blur_, inverse_blur_;
};

}  // namespace kiln::phantom
