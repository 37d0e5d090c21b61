#include "ingest/dicom/dicom_plane.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace kiln {

std::string orientationFault(const DicomFrame& frame) {
  constexpr double kTolerance = 0.01;
  const glm::dvec3 x = *frame.along_row, y = *frame.along_column;
  const bool square = std::abs(glm::length(x) - 1) < kTolerance && std::abs(glm::length(y) - 1) < kTolerance &&
                      std::abs(glm::dot(x, y)) < kTolerance;
  return square ? "" : "the orientation is not two unit vectors at a right angle";
}

// Directions are decimal strings rounded to a few digits.
bool isTurned(const DicomFrame& frame, const DicomFrame& against) {
  constexpr double kTolerance = 1e-3;
  return std::max(glm::distance(*frame.along_row, *against.along_row),
                  glm::distance(*frame.along_column, *against.along_column)) > kTolerance;
}

bool isResized(const DicomFrame& frame, const DicomFrame& than) {
  constexpr double kTolerance = 1e-4;
  return !frame.spacing || glm::distance(*frame.spacing, *than.spacing) > kTolerance * glm::length(*than.spacing);
}

}  // namespace kiln
