#include "ingest/source_words.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string_view>

#include "base/error.h"
#include "base/text.h"
#include "grid/length_unit.h"
#include "ingest/source/placement.h"

namespace kiln {
namespace {

std::array<bool, 3> parseFlip(const std::string& text) {
  constexpr std::string_view kAxes = "xyz";
  std::array<bool, 3> out{};
  for (const std::string_view axis : splitAt(text, ',')) {
    const std::size_t at = axis.size() == 1 ? kAxes.find(axis.front()) : std::string_view::npos;
    if (at == std::string_view::npos || out[at])
      throw Error(ErrorCode::kUsage, fmt::format("--flip: expected x, y, z or a list such as x,z, found '{}'", text));
    out[at] = true;
  }
  return out;
}

Placement parsePlacement(const SourceWords& a) {
  Placement out;
  if (!a.flip.empty()) out.flip = parseFlip(a.flip);
  if (!a.orient.empty()) {
    out.axes = axisLettersOf(a.orient);
    if (!out.axes)
      throw Error(ErrorCode::kUsage, fmt::format("--orient: expected three letters, one of R or L, A or P, and S or I, "
                                                 "such as LPS (found '{}')",
                                                 a.orient));
  }
  if (!a.up.empty() && a.up != "y" && a.up != "z")
    throw Error(ErrorCode::kUsage, fmt::format("--up-axis: expected y or z, found '{}'", a.up));
  if (a.up == "y") out.up = UpAxis::kY;
  if (!a.unit.empty()) {
    out.unit = unitName(a.unit);
    if (out.unit.empty())
      throw Error(ErrorCode::kUsage,
                  fmt::format("--unit: expected a unit of length, such as nm, um, mm or m (found '{}')", a.unit));
  }
  return out;
}

}  // namespace

glm::dvec3 tripleOfText(const std::string& text, const char* option) {
  glm::dvec3 out;
  const std::vector<std::string_view> parts = splitAt(text, ',');
  for (std::size_t i = 0; i < 3; ++i) {
    const std::optional<double> value = parts.size() == 3 ? decimalOf<double>(parts[i]) : std::nullopt;
    if (!value)
      throw Error(ErrorCode::kUsage, fmt::format("{}: expected three finite numbers X,Y,Z, found '{}'", option, text));
    out[static_cast<int>(i)] = *value;
  }
  return out;
}

SourceOptions SourceWords::resolve() const {
  SourceOptions out;
  if (!dims.empty()) {
    const glm::dvec3 d = tripleOfText(dims, "--dims");
    for (int axis = 0; axis < 3; ++axis) {
      if (!(d[axis] >= 1) || d[axis] != std::floor(d[axis]) || d[axis] > 2147483647.0) {
        throw Error(ErrorCode::kUsage, fmt::format("--dims: expected three positive whole numbers, found '{}'", dims));
      }
    }
    out.dims = Extent3{static_cast<std::int64_t>(d.x), static_cast<std::int64_t>(d.y), static_cast<std::int64_t>(d.z)};
  }
  if (!type.empty()) {
    out.type = voxelTypeNamed(type);
    if (!out.type)
      throw Error(ErrorCode::kUsage, fmt::format("--type: '{}' is not one of u8 i8 u16 i16 u32 i32 f32 f64", type));
  }
  if (!endian.empty()) {
    if (endian != "little" && endian != "big")
      throw Error(ErrorCode::kUsage, fmt::format("--endian: expected little or big, found '{}'", endian));
    out.big_endian = endian == "big";
  }
  out.skip_bytes = skip;
  if (!spacing.empty()) {
    out.spacing = tripleOfText(spacing, "--spacing");
    if (!(out.spacing->x > 0 && out.spacing->y > 0 && out.spacing->z > 0))
      throw Error(ErrorCode::kUsage, fmt::format("--spacing: expected three positive numbers, found '{}'", spacing));
  }
  if (!grid.empty()) out.grid_name = grid;
  if (!series.empty()) out.series = series;
  out.channel = channel;
  out.time = time;
  out.scale = scale;
  out.placement = parsePlacement(*this);
  out.allow_irregular = allow_irregular;
  out.luminance = luminance;
  return out;
}

}  // namespace kiln
