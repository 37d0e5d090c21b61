// The sides of slices: which axes of voxels run along a picture's columns and rows, and which way.
// Convention. A patient's slices are drawn as radiology draws them, and as 3D Slicer and ITK-SNAP do: axial slices with
// the front up and coronal slices with the head up, both with the patient's right at the left; sagittal slices with the
// head up and the front at the left. In the axes of LPS this is x to the right and y down, x to the right and z up, and
// y to the right and z up. A volume without a patient frame is drawn as if its axes of voxels were those of LPS.
#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>

#include "grid/geometry.h"

namespace kiln {

/// The one of three directions that is nearest to an axis of the patient.
struct NearestAxis {
  int index = 0;          // 0 x, 1 y, 2 z
  bool mirrored = false;  // the direction runs to the patient's right, front or feet
};
/// Returns the columns of `directions` that are nearest to the patient's left, back and head, a column for each.
/// Columns may be oblique, and of any length. unit: world.
std::array<NearestAxis, 3> nearestToPatient(const glm::dmat3& directions, PatientFrame frame);

/// Letters of the patient's sides at a picture's edges; zero for a volume without a patient frame.
struct EdgeLetters {
  char left = 0, right = 0, top = 0, bottom = 0;
};
/// Returns the letters of a picture whose columns and rows grow to the right and down. requires: independent
/// directions. unit: world.
EdgeLetters edgeLetters(const glm::dvec3& right, const glm::dvec3& down, PatientFrame frame);

struct SliceView {
  const char* plane = "";           // axial, coronal or sagittal; empty without a patient frame
  NearestAxis across, right, down;  // axes of voxels
  bool from_bottom = false;         // the first row of voxels, before mirroring, is the picture's lowest
  EdgeLetters letters;

  /// Returns the middle slice: of volumes that differ in mirrored axes, the same slice.
  static std::int64_t middle(const NearestAxis& axis, const Extent3& dims) {
    return (dims[axis.index] - (axis.mirrored ? 1 : 0)) / 2;
  }
};
/// Returns the views along the patient's axes: axial, coronal, sagittal; without a patient frame along z, y and x.
std::array<SliceView, 3> sliceViews(const VolumeGeometry& volume);
/// Returns the view across an axis of voxels.
SliceView sliceViewAcross(const VolumeGeometry& volume, int axis);
/// Returns the middle voxel: of volumes that differ in mirrored axes, the same voxel.
VoxelCoord middleVoxel(const VolumeGeometry& volume);

}  // namespace kiln
