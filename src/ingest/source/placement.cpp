#include "ingest/source/placement.h"

#include <algorithm>
#include <cctype>

#include "base/error.h"
#include "grid/length_unit.h"

namespace kiln {
namespace {

// A letter's world axis and sign in RAS.
struct Direction {
  char letter;
  int axis;
  double sign;
};
constexpr std::array<Direction, 6> kDirections = {
    {{'R', 0, 1}, {'L', 0, -1}, {'A', 1, 1}, {'P', 1, -1}, {'S', 2, 1}, {'I', 2, -1}}};

const Direction* directionOf(char letter) {
  const auto found = std::find_if(kDirections.begin(), kDirections.end(),
                                  [&](const Direction& direction) { return direction.letter == letter; });
  return found == kDirections.end() ? nullptr : &*found;
}

glm::dmat4 mirrored(glm::dmat4 affine, int axis, std::int64_t voxels) {
  affine[3] += affine[axis] * static_cast<double>(voxels - 1);
  affine[axis] = glm::dvec4(0) - affine[axis];  // no zero becomes -0
  return affine;
}

glm::dmat4 directed(const glm::dmat4& upright, const AxisLetters& axes) {
  glm::dmat4 out = upright;
  for (int column = 0; column < 3; ++column) {
    const Direction& direction = *directionOf(axes[static_cast<std::size_t>(column)]);
    out[column] = glm::dvec4(0);
    out[column][direction.axis] = direction.sign * upright[column][column];
  }
  return out;
}

// Turns y to z, and z to -y.
glm::dmat4 withYUp(glm::dmat4 affine) {
  for (int column = 0; column < 4; ++column) {
    const double y = affine[column].y, z = affine[column].z;
    affine[column].y = 0 - z;
    affine[column].z = y;
  }
  return affine;
}

}  // namespace

std::optional<AxisLetters> axisLettersOf(std::string_view text) {
  AxisLetters out(text);
  std::array<bool, 3> named{};
  for (char& letter : out) {
    letter = static_cast<char>(std::toupper(static_cast<unsigned char>(letter)));
    const Direction* const direction = directionOf(letter);
    if (direction == nullptr || named[static_cast<std::size_t>(direction->axis)]) return std::nullopt;
    named[static_cast<std::size_t>(direction->axis)] = true;
  }
  return out.size() == named.size() ? std::optional(out) : std::nullopt;
}

VolumeGeometry placed(const VolumeGeometry& geometry, const Placement& placement, const std::string& file) {
  const auto refuse = [&](const char* option, const std::string& why) {
    throw Error(ErrorCode::kUsage, file, option, why);
  };
  const bool patient = geometry.frame != PatientFrame::kUnknown;
  VolumeGeometry out = geometry;
  if (placement.axes) {
    if (patient || !geometry.isUnturned())
      refuse("--orient", std::string("is for files without directions of axes (found ") +
                             (patient ? "a patient frame" : "a rotated or mirrored affine") +
                             "); leave it out, or mirror axes with --flip");
    if (placement.up != UpAxis::kZ) refuse("--orient", "states which way is up (found --up-axis, too); leave one out");
    out.world_from_index = directed(out.world_from_index, *placement.axes);
    out.frame = PatientFrame::kRas;
  }
  if (placement.up == UpAxis::kY) {
    if (patient) refuse("--up-axis", "is for files without a patient frame (found one, with z up); leave it out");
    out.world_from_index = withYUp(out.world_from_index);
  }
  if (!placement.unit.empty()) {
    if (!out.unit.empty() && unitName(out.unit) != placement.unit)
      refuse("--unit", "is for files that state no unit of length (found " + out.unit + "); leave it out");
    out.unit = placement.unit;
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (placement.flip[static_cast<std::size_t>(axis)])
      out.world_from_index = mirrored(out.world_from_index, axis, out.dims[axis]);
  }
  return out;
}

std::string orientationNote(const SourceInfo& info) {
  const VolumeGeometry& geometry = info.geometry;
  const bool open = geometry.frame == PatientFrame::kUnknown && geometry.isUnturned();
  // A computed volume has no files. The grids of OpenVDB have z or y up by custom, and no patient.
  if (!open || info.files.empty() || info.vdb) return {};
  return "states no orientation; x is taken as left, y as back, z as up; --orient sets another, such as --orient RAS";
}

}  // namespace kiln
