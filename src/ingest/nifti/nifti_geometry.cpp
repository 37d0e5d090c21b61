// Affine of a NIfTI-1 file: the sform (rows) takes precedence over the qform (quaternion); both map to RAS. A header
// with neither has spacings alone. Every number of the header is checked before use.
// Source: nifti1.h, https://nifti.nimh.nih.gov/nifti-1.
#include "ingest/nifti/nifti_geometry.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>

#include "base/error.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

using enum NiftiHeader::Field;

Extent3 dimsOf(const NiftiHeader& header) {
  const int count = header.i16(kDim);
  if (count < 1 || count > 7) header.fail("byte 40", fmt::format("dim[0] is {}; 1 to 7 are legal", count));
  std::array<std::int64_t, 8> dim{};
  for (std::size_t i = 1; i <= static_cast<std::size_t>(count); ++i) {
    dim[i] = header.i16(kDim + 2 * i);
    if (dim[i] < 1) header.fail(fmt::format("byte {}", kDim + 2 * i), fmt::format("dim[{}] is {}", i, dim[i]));
  }
  if (count < 3) header.refuse(fmt::format("has {} dimensions; Kiln reads volumes", count));
  if (count >= 4 && dim[4] > 1)
    header.refuse(fmt::format("is a time series of {} volumes; extract one of them", dim[4]));
  for (std::size_t i = 5; i <= static_cast<std::size_t>(count); ++i) {
    if (dim[i] > 1)
      header.refuse(fmt::format("holds {} values a voxel (dim[{}]); Kiln reads scalar volumes", dim[i], i));
  }
  return {dim[1], dim[2], dim[3]};
}

// nifti1.h, METHOD 2: the quaternion's rotation; the third axis is mirrored if qfac (pixdim[0]) is negative.
glm::dmat4 quaternionAffine(const NiftiHeader& header, const glm::dvec3& spacing) {
  double b = header.f32(kQuaternB), c = header.f32(kQuaternB + 4), d = header.f32(kQuaternB + 8);
  double a = 1 - (b * b + c * c + d * d);
  if (a < 1e-7) {  // a half turn, up to rounding
    const double length = std::sqrt(b * b + c * c + d * d);
    b /= length, c /= length, d /= length;
    a = 0;
  } else {
    a = std::sqrt(a);
  }
  const double qfac = header.f32(kPixdim) < 0 ? -1 : 1;
  const glm::dvec3 x(a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c));
  const glm::dvec3 y(2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b));
  const glm::dvec3 z(2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - c * c - b * b);
  const glm::dvec3 origin(header.f32(kQoffsetX), header.f32(kQoffsetX + 4), header.f32(kQoffsetX + 8));
  return glm::dmat4(glm::dvec4(x * spacing.x, 0), glm::dvec4(y * spacing.y, 0), glm::dvec4(z * (spacing.z * qfac), 0),
                    glm::dvec4(origin, 1));
}

glm::dmat4 rowsAffine(const NiftiHeader& header) {
  glm::dmat4 out(1.0);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      out[column][row] = header.f32(kSrowX + 16 * static_cast<std::size_t>(row) + 4 * static_cast<std::size_t>(column));
    }
  }
  return out;
}

std::string unitOf(const NiftiHeader& header) {
  switch (header.byteAt(kXyztUnits) & 7) {
    case 1:
      return "m";
    case 2:
      return "mm";
    case 3:
      return "um";
    default:
      return "";
  }
}

// Returns the edge lengths of a voxel. The format requires positive numbers: a sign is a known mistake of writers and
// is ignored. Writers use 0 for an unknown length.
glm::dvec3 spacingOf(const NiftiHeader& header, std::vector<std::string>& notes) {
  glm::dvec3 out;
  for (int axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis) + 1;
    const double found = header.f32(kPixdim + 4 * i);
    out[axis] = std::abs(found);
    if (std::isfinite(found) && found != 0) continue;
    out[axis] = 1;
    notes.push_back(fmt::format("pixdim[{}] is {}; a spacing of 1 is taken", i, found));
  }
  return out;
}

bool isInvertible(const glm::dmat4& affine) {
  try {
    requireInvertible(affine, "");
    return true;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

VolumeGeometry niftiGeometry(const NiftiHeader& header, const SourceOptions& options, std::vector<std::string>& notes) {
  VolumeGeometry out;
  out.dims = dimsOf(header);
  out.unit = unitOf(header);
  bool rows = header.i16(kSformCode) > 0;
  const bool quaternion = header.i16(kQformCode) > 0;
  const glm::dmat4 sform = rowsAffine(header);
  // A set sform code with empty rows gives no affine; a damaged sform without a qform is an error.
  const bool empty = sform == glm::dmat4(glm::dvec4(0), glm::dvec4(0), glm::dvec4(0), glm::dvec4(0, 0, 0, 1));
  if (rows && !isInvertible(sform) && (quaternion || empty)) {
    rows = false;
    notes.push_back(fmt::format("its sform {}; {}", empty ? "is empty" : "has no volume",
                                quaternion ? "the qform is taken" : "the spacing alone is taken"));
  }
  if (rows || quaternion) {
    if (options.spacing) refuseSpacing(header.path());
    out.world_from_index = rows ? sform : quaternionAffine(header, spacingOf(header, notes));
    out.frame = PatientFrame::kRas;
  } else {
    out.world_from_index = glm::scale(glm::dmat4(1.0), options.spacing ? *options.spacing : spacingOf(header, notes));
  }
  requireInvertible(out.world_from_index, header.path().string());
  return out;
}

}  // namespace kiln
