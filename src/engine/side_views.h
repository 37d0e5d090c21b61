// A volume seen along each of its axes, in pixels of a voxel: which part of the volume a picture must hold.
// Problem. A few voxels far from an object, such as noise or nails of a table, must not decide the size of a picture.
// Nothing else that a person sees may be cut off.
// Method. A pixel has the opacity of its column of cells. Pixels that touch are an object; objects that together are a
// negligible share of all opacity are left out. The box holds each object that counts in a view of some axis. A cell
// counts if its pixels count in two views, since a stray voxel in front of an object counts in that view alone, or if a
// pixel that counts has no such cell.
// Source: Laurentini 1994 (visual hulls).
#pragma once

#include <array>
#include <cstdint>
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
  /// True if a cell of the box shows something.
  bool showsIn(const VoxelBox& box) const;
  /// Returns the box of the voxels that count; empty if nothing shows.
  VoxelBox box() const;
  /// Returns, for each row along x that has cells that count, the box of the row's first to last such cell.
  std::vector<VoxelBox> rows() const;

 private:
  // The pixels of a view that count, and the rectangle around them.
  struct Counted {
    std::vector<bool> pixels;
    std::array<std::int64_t, 2> lo, hi;  // half-open; empty if lo > hi
  };
  struct View {
    int width, height;                // along the two next axes
    std::vector<float> depths, thin;  // optical depths of columns; opacities of matter thinner than a voxel
    std::vector<float> opacities() const;
    Counted counted() const;
  };
  // Cells that show something, a bit each, in rows of words.
  std::uint64_t& wordOf(const VoxelCoord& cell) {
    return shown_[static_cast<std::size_t>((cell.z * dims_.y + cell.y) * words_ + cell.x / 64)];
  }
  bool shows(const VoxelCoord& cell) const {
    return shown_[static_cast<std::size_t>((cell.z * dims_.y + cell.y) * words_ + cell.x / 64)] >> (cell.x % 64) & 1;
  }

  std::array<View, 3> views_;  // along x, y and z
  Extent3 dims_;
  std::int64_t words_;  // of a row
  std::vector<std::uint64_t> shown_;
};

}  // namespace kiln
