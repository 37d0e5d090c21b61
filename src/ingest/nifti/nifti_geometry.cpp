// Affine of a NIfTI file: the sform (rows) takes precedence over the qform (quaternion); both map to RAS. A header
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

using enum NiftiField;

// dim[0] is the number of dimensions; dim[1] to dim[7] are their lengths, 1 for further ones. Writers count further
// dimensions and leave their lengths at 0, which stands for 1. Source: nifti_convert_nhdr2nim of nifti1_io.c.
using NiftiDims = std::array<std::int64_t, 8>;

NiftiDims dimsOf(const NiftiHeader& header) {
  const std::int64_t count = header.integer(kDim);
  if (count < 1 || count > 7) header.fail(kDim, 0, fmt::format("dim[0] is {}; 1 to 7 are legal", count));
  NiftiDims dim;
  dim.fill(1);
  dim[0] = count;
  for (std::size_t i = 1; i <= static_cast<std::size_t>(count); ++i) {
    dim[i] = header.integer(kDim, i);
    if (i > 3 && dim[i] == 0) dim[i] = 1;
    if (dim[i] < 1) header.fail(kDim, i, fmt::format("dim[{}] is {}", i, dim[i]));
  }
  return dim;
}

// nifti1.h, METHOD 2: the quaternion's rotation; the third axis is mirrored if qfac (pixdim[0]) is negative.
glm::dmat4 quaternionAffine(const NiftiHeader& header, const glm::dvec3& spacing) {
  double b = header.real(kQuaternB), c = header.real(kQuaternB, 1), d = header.real(kQuaternB, 2);
  double a = 1 - (b * b + c * c + d * d);
  if (a < 1e-7) {  // a half turn, up to rounding
    const double length = std::sqrt(b * b + c * c + d * d);
    b /= length, c /= length, d /= length;
    a = 0;
  } else {
    a = std::sqrt(a);
  }
  const double qfac = header.real(kPixdim) < 0 ? -1 : 1;
  const glm::dvec3 x(a * a + b * b - c * c - d * d, 2 * (b * c + a * d), 2 * (b * d - a * c));
  const glm::dvec3 y(2 * (b * c - a * d), a * a + c * c - b * b - d * d, 2 * (c * d + a * b));
  const glm::dvec3 z(2 * (b * d + a * c), 2 * (c * d - a * b), a * a + d * d - c * c - b * b);
  const glm::dvec3 origin(header.real(kQoffsetX), header.real(kQoffsetX, 1), header.real(kQoffsetX, 2));
  return glm::dmat4(glm::dvec4(x * spacing.x, 0), glm::dvec4(y * spacing.y, 0), glm::dvec4(z * (spacing.z * qfac), 0),
                    glm::dvec4(origin, 1));
}

glm::dmat4 rowsAffine(const NiftiHeader& header) {
  glm::dmat4 out(1.0);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column) {
      out[column][row] = header.real(kSrowX, static_cast<std::size_t>(4 * row + column));
    }
  }
  return out;
}

std::string unitOf(const NiftiHeader& header) {
  switch (header.integer(kXyztUnits) & 7) {
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
    const double found = header.real(kPixdim, i);
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

std::int64_t niftiTimes(const NiftiHeader& header) {
  const NiftiDims dim = dimsOf(header);
  if (dim[0] < 3) header.refuse(fmt::format("has {} dimensions; Kiln reads volumes", dim[0]));
  for (std::size_t i = 5; i < dim.size(); ++i) {
    if (dim[i] > 1)
      header.refuse(fmt::format("holds {} values a voxel (dim[{}]); Kiln reads scalar volumes", dim[i], i));
  }
  return dim[4];
}

VolumeGeometry niftiGeometry(const NiftiHeader& header, const SourceOptions& options, std::vector<std::string>& notes) {
  VolumeGeometry out;
  const NiftiDims dim = dimsOf(header);
  out.dims = {dim[1], dim[2], dim[3]};
  out.unit = unitOf(header);
  bool rows = header.integer(kSformCode) > 0;
  const bool quaternion = header.integer(kQformCode) > 0;
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
