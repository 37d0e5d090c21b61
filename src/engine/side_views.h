// A volume seen along each of its axes, in pixels of a voxel: which part of the volume a picture must hold.
// Problem. A few voxels far from an object, such as noise or nails of a table, must not decide the size of a picture.
// Nothing else that a person sees may be cut off.
// Method. A pixel has the opacity of its column of cells. Pixels that touch are an object; objects that together are a
// negligible share of all opacity are left out. An object counts if it counts in a view of some axis.
#pragma once

#include <array>
#include <vector>

#include "grid/coords.h"

namespace kiln {

/// Optical depth below which a column is black to the eye: white light of this opacity on black is 8 of 255 steps of
/// sRGB.
inline constexpr double kLeastColumn = 0.0025;

class SideViews {
 public:
  explicit SideViews(const Extent3& dims);

  /// Adds optical depth to the columns of a cell: a voxel and its next neighbours. `depth`: along each axis.
  void add(const VoxelCoord& cell, const std::array<double, 3>& depth);
  /// Adds a box of voxels where something shows that is thinner than a voxel: `opacity` is its mean over the box.
  void addThin(const VoxelBox& box, double opacity);
  /// Returns the box of the voxels that count; empty if nothing shows.
  VoxelBox box() const;

 private:
  struct View {
    int width, height;                // along the two next axes
    std::vector<float> depths, thin;  // optical depths of columns; opacities of matter thinner than a voxel
    std::vector<float> opacities() const;
  };
  std::array<View, 3> views_;  // along x, y and z
  Extent3 dims_;
};

}  // namespace kiln
