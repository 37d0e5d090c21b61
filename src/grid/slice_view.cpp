#include "grid/slice_view.h"

#include <cmath>
#include <glm/geometric.hpp>

namespace kiln {
namespace {

// Sides of the patient's axes, against LPS and along LPS.
constexpr char kPatientSides[3][2] = {{'R', 'L'}, {'A', 'P'}, {'I', 'S'}};

// Sums of cosines that differ by less are equal: a volume turned by 45 degrees keeps the order of its axes.
constexpr double kSumRounding = 1e-9;

NearestAxis voxelAxisOf(const VolumeGeometry& volume, std::size_t patient_axis) {
  if (volume.frame == PatientFrame::kUnknown) return {static_cast<int>(patient_axis), false};
  return nearestToPatient(glm::dmat3(volume.world_from_index), volume.frame)[patient_axis];
}

}  // namespace

std::array<NearestAxis, 3> nearestToPatient(const glm::dmat3& directions, PatientFrame frame) {
  const PatientAxes axes = patientAxes(frame);
  glm::dmat3 lps;
  for (int column = 0; column < 3; ++column) {
    const glm::dvec3 direction = glm::normalize(directions[column]);
    lps[column] = {glm::dot(direction, axes.left), -glm::dot(direction, axes.anterior),
                   glm::dot(direction, axes.superior)};
  }
  static constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  const int* best = nullptr;
  double greatest = 0;
  // Each alone would give two axes of the patient to one column of an oblique volume.
  for (const auto& order : kOrders) {
    double sum = 0;
    for (int axis = 0; axis < 3; ++axis) sum += std::abs(lps[order[axis]][axis]);
    if (best != nullptr && sum < greatest + kSumRounding) continue;
    best = order;
    greatest = sum;
  }
  std::array<NearestAxis, 3> out;
  for (int axis = 0; axis < 3; ++axis) out[static_cast<std::size_t>(axis)] = {best[axis], lps[best[axis]][axis] < 0};
  return out;
}

EdgeLetters edgeLetters(const glm::dvec3& right, const glm::dvec3& down, PatientFrame frame) {
  EdgeLetters out;
  if (frame == PatientFrame::kUnknown) return out;
  const std::array<NearestAxis, 3> nearest = nearestToPatient({right, down, glm::cross(right, down)}, frame);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& sides = kPatientSides[axis];
    const char ahead = sides[nearest[axis].mirrored ? 0 : 1], behind = sides[nearest[axis].mirrored ? 1 : 0];
    if (nearest[axis].index == 0) out.left = behind, out.right = ahead;
    if (nearest[axis].index == 1) out.top = behind, out.bottom = ahead;
  }
  return out;
}

std::array<SliceView, 3> sliceViews(const VolumeGeometry& volume) {
  const NearestAxis left = voxelAxisOf(volume, 0), back = voxelAxisOf(volume, 1), head = voxelAxisOf(volume, 2);
  std::array<SliceView, 3> out = {{{"axial", head, left, back, false, {'R', 'L', 'A', 'P'}},
                                   {"coronal", back, left, head, true, {'R', 'L', 'S', 'I'}},
                                   {"sagittal", left, back, head, true, {'A', 'P', 'S', 'I'}}}};
  if (volume.frame == PatientFrame::kUnknown) {
    for (SliceView& view : out) view.plane = "", view.letters = {};
  }
  return out;
}

SliceView sliceViewAcross(const VolumeGeometry& volume, int axis) {
  const std::array<SliceView, 3> views = sliceViews(volume);
  for (const SliceView& view : views) {
    if (view.across.index == axis) return view;
  }
  return views.front();
}

VoxelCoord middleVoxel(const VolumeGeometry& volume) {
  VoxelCoord out;
  for (const SliceView& view : sliceViews(volume)) out[view.across.index] = SliceView::middle(view.across, volume.dims);
  return out;
}

}  // namespace kiln
