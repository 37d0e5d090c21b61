// Paints blocks of 8³ voxels: finds the shapes near a block and computes its voxels without noise. Internal to the
// sampler.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "phantom/sampler.h"

namespace kiln::phantom {

inline constexpr int kEdge = 8;
inline constexpr int kBlockVoxels = kEdge * kEdge * kEdge;

// Bounds of a distance over all voxel centres of a box, widened by more than rounding. unit: mm.
struct Bounds {
  float lo, hi;
};

// The shapes that affect a box, grouped by part from the highest precedence down.
struct NearShape {
  std::uint32_t index;  // index in the figure
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

// The ball around the voxel centres of a block, and the half edges of the box around them. unit: mm.
struct Ball {
  float centre[3], half[3], radius;
};

// Working memory of one thread for one block: voxel coordinates, and numbers per voxel.
struct Work {
  float x[kEdge], y[kEdge], z[kEdge];
  int lo_y, hi_y, lo_z, hi_z;  // rows to paint
  alignas(64) float d[kBlockVoxels];
  alignas(64) float outer[kBlockVoxels];
  alignas(64) float inner[kBlockVoxels];
  alignas(64) float value[kBlockVoxels];
  alignas(64) float left[kBlockVoxels];  // share of the voxel that no tissue has yet
  bool blank;                            // no tissue has a share yet; `value` and `left` are not set

  // Calls f(offset) for each row to paint.
  template <class F>
  void rows(F&& f) {
    for (int k = lo_z; k < hi_z; ++k) {
      for (int j = lo_y; j < hi_y; ++j) f((k * kEdge + j) * kEdge);
    }
  }
  // Calls f(index) for each voxel to paint; a simple f is vectorised.
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

  // Selects the shapes whose boxes are in reach of the box, without bounds of distances.
  void choose(const VoxelBox& box, NearShapes& out) const;
  // Selects from `from` the shapes near the box. requires: `from` was selected for a box that contains this box, and,
  // if `from` has bounds, for a box of equal proportions.
  void choose(const VoxelBox& box, const NearShapes& from, NearShapes& out) const;
  // Computes the values without noise of the block that `near` was selected for. Returns the value of a uniform block,
  // else fills work.value.
  std::optional<float> paint(const NearShapes& near, Work& work) const noexcept;

 private:
  Ball ballAround(const VoxelBox& box) const;
  bool isInReach(std::size_t shape, const Ball& ball) const;
  // Returns the bounds of the distance; nothing if the shape is not near.
  std::optional<Bounds> boundsIfNear(std::size_t shape, const Ball& ball) const;
  // Paints a part. Returns a tissue if the block is finished: the tissue takes all that is left of the voxels.
  std::optional<Tissue> paintPart(const NearShapes& near, const NearPart& chosen, Work& work) const noexcept;
  void computeSurfaces(const Part& part, std::span<const NearShape> near, bool inner, Work& work) const noexcept;

  const Figure& figure_;
  const Lattice& lattice_;
  const ValueTable& values_;
  float blur_, inverse_blur_;
};

}  // namespace kiln::phantom
