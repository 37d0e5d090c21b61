#include "grid/shared_world.h"

#include <fmt/format.h>

#include <string_view>

namespace kiln {
namespace {

std::string_view lettersOf(PatientFrame frame) { return frame == PatientFrame::kRas ? "RAS" : "LPS"; }

}  // namespace

VolumeGeometry sharedWorld(const std::vector<VolumeGeometry>& volumes) {
  VolumeGeometry out = volumes.front();
  for (const VolumeGeometry& volume : volumes) {
    if (out.frame == PatientFrame::kUnknown) out.frame = volume.frame;
    if (out.unit.empty()) out.unit = volume.unit;
  }
  return out;
}

glm::dmat4 WorldChange::of(const glm::dmat4& world_from_index) const {
  if (none()) return world_from_index;
  glm::dmat4 out = world_from_index;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      out[column][row] = lengths.of(out[column][row]);
      if (turned && row < 2) out[column][row] = 0 - out[column][row];  // no zero becomes -0
    }
  }
  return out;
}

WorldChange worldChange(const VolumeGeometry& own, const VolumeGeometry& world) {
  WorldChange out;
  out.turned = own.frame != world.frame && own.frame != PatientFrame::kUnknown && world.frame != PatientFrame::kUnknown;
  if (!own.unit.empty() && !world.unit.empty()) out.lengths = lengthRatio(own.unit, world.unit).value_or(LengthRatio());
  return out;
}

std::string assumptionText(const VolumeGeometry& own, const VolumeGeometry& world) {
  std::string out;
  if (own.frame == PatientFrame::kUnknown && world.frame != PatientFrame::kUnknown)
    out = fmt::format("its patient frame is unknown, and another volume's is {0}: it is drawn as if its frame were {0}",
                      lettersOf(world.frame));
  if (world.unit.empty() || lengthRatio(own.unit, world.unit)) return out;
  if (!out.empty()) out += "; ";
  if (own.unit.empty())
    out += fmt::format("its unit of length is unknown, and another volume's is '{0}': its lengths are taken as '{0}'",
                       world.unit);
  else
    out += fmt::format("lengths in '{0}' cannot be converted to another volume's '{1}': they are taken as '{1}'",
                       own.unit, world.unit);
  return out;
}

}  // namespace kiln
