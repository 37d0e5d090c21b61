#include "grid/shared_world.h"

#include <fmt/format.h>

#include <array>
#include <numeric>
#include <utility>

namespace kiln {
namespace {

// Lengths in picometres: a double is exact up to a kilometre.
constexpr std::array<std::pair<std::string_view, std::int64_t>, 30> kUnits_pm = {{
    {"pm", 1},
    {"angstrom", 100},
    {"Angstrom", 100},
    {"\u00c5", 100},
    {"A", 100},
    {"nm", 1'000},
    {"nanometer", 1'000},
    {"nanometre", 1'000},
    {"um", 1'000'000},
    {"\u00b5m", 1'000'000},
    {"\u03bcm", 1'000'000},
    {"micron", 1'000'000},
    {"microns", 1'000'000},
    {"micrometer", 1'000'000},
    {"micrometre", 1'000'000},
    {"mm", 1'000'000'000},
    {"millimeter", 1'000'000'000},
    {"millimetre", 1'000'000'000},
    {"cm", 10'000'000'000},
    {"centimeter", 10'000'000'000},
    {"centimetre", 10'000'000'000},
    {"in", 25'400'000'000},
    {"inch", 25'400'000'000},
    {"dm", 100'000'000'000},
    {"ft", 304'800'000'000},
    {"m", 1'000'000'000'000},
    {"meter", 1'000'000'000'000},
    {"metre", 1'000'000'000'000},
    {"km", 1'000'000'000'000'000},
    {"kilometer", 1'000'000'000'000'000},
}};

std::optional<std::int64_t> picometresOf(std::string_view unit) {
  for (const auto& [name, length] : kUnits_pm) {
    if (unit == name) return length;
  }
  return std::nullopt;
}

std::string_view lettersOf(PatientFrame frame) { return frame == PatientFrame::kRas ? "RAS" : "LPS"; }

}  // namespace

std::optional<LengthRatio> lengthRatio(std::string_view from, std::string_view to) {
  if (from == to) return LengthRatio();
  const auto from_pm = picometresOf(from), to_pm = picometresOf(to);
  if (!from_pm || !to_pm) return std::nullopt;
  const std::int64_t common = std::gcd(*from_pm, *to_pm);
  return LengthRatio{static_cast<double>(*from_pm / common), static_cast<double>(*to_pm / common)};
}

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
      if (turned && row < 2) out[column][row] = -out[column][row];
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
