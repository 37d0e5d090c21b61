// World space is RAS or LPS if `space` names either. Left-anterior-superior is mirrored in x into RAS, because Kiln
// has no name for it. All other spaces have no patient frame.
// Source: teem.sourceforge.net/nrrd/format.html.
#include "ingest/nrrd/nrrd_geometry.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.h"
#include "base/text.h"
#include "grid/length_unit.h"

namespace kiln {
namespace {

// Parses "(1,0,0) (0,1,0) …"; punctuation must be where the format requires it.
std::vector<glm::dvec3> vectorsOf(const HeaderFields& fields, const HeaderField& field, std::size_t count) {
  std::vector<glm::dvec3> out;
  std::string_view rest = field.value;
  while (!rest.empty()) {
    const std::size_t close = rest.find(')');
    if (rest.front() != '(' || close == std::string_view::npos) break;
    HeaderField inside = field;
    inside.value = std::string(rest.substr(1, close - 1));
    if (std::count(inside.value.begin(), inside.value.end(), ',') != 2) break;
    std::replace(inside.value.begin(), inside.value.end(), ',', ' ');
    out.push_back(fields.vector(inside));
    rest.remove_prefix(close + 1);
    rest.remove_prefix(std::min(rest.find_first_not_of(" \t"), rest.size()));
  }
  if (!rest.empty() || out.size() != count) {
    fields.fail(field, inQuotes(field.value) + " is not " + std::to_string(count) + " vectors like (1,0,0)");
  }
  return out;
}

PatientFrame frameOf(const HeaderFields& fields, bool& mirror_x) {
  const HeaderField* space = fields.find("space");
  const HeaderField* count = fields.find("space dimension");
  if (space && count) fields.fail(*count, "contradicts 'space' in line " + std::to_string(space->line));
  if (count && fields.integers(*count, 1)[0] != 3) fields.unsupported(*count, count->value + "-D space is not read");
  if (!space) return PatientFrame::kUnknown;
  const std::string name = lowered(space->value);
  if (name == "right-anterior-superior" || name == "ras") return PatientFrame::kRas;
  if (name == "left-posterior-superior" || name == "lps") return PatientFrame::kLps;
  if (name == "left-anterior-superior" || name == "las") {
    mirror_x = true;
    return PatientFrame::kRas;
  }
  if (name == "scanner-xyz" || name == "3d-right-handed" || name == "3d-left-handed") return PatientFrame::kUnknown;
  static const char* const kOverTime[] = {"right-anterior-superior-time",
                                          "rast",
                                          "left-posterior-superior-time",
                                          "lpst",
                                          "left-anterior-superior-time",
                                          "last",
                                          "scanner-xyz-time",
                                          "3d-right-handed-time",
                                          "3d-left-handed-time"};
  const bool over_time = std::find(std::begin(kOverTime), std::end(kOverTime), name) != std::end(kOverTime);
  if (over_time) fields.unsupported(*space, inQuotes(space->value) + " has a time axis; give one volume of the series");
  fields.fail(*space, inQuotes(space->value) + " is not a space of NRRD");
}

// The unit of x, and the ratios that convert lengths along each axis to this unit.
struct AxisUnits {
  std::string unit;
  std::array<LengthRatio, 3> to_unit;
  glm::dvec3 of(const glm::dvec3& lengths) const {
    return {to_unit[0].of(lengths.x), to_unit[1].of(lengths.y), to_unit[2].of(lengths.z)};
  }
};

std::vector<std::string> quotedTexts(const HeaderFields& fields, const HeaderField& field) {
  std::vector<std::string> out;
  for (std::size_t at = 0; (at = field.value.find('"', at)) != std::string::npos;) {
    const std::size_t end = field.value.find('"', at + 1);
    if (end == std::string::npos) fields.fail(field, "a quotation mark is not closed");
    out.push_back(field.value.substr(at + 1, end - at - 1));
    at = end + 1;
  }
  return out;
}

// An unknown unit stays as written. Units of axes that have directions in the world cannot be converted.
AxisUnits unitsOf(const HeaderFields& fields, std::vector<std::string>& notes) {
  const HeaderField* const of_space = fields.find("space units");
  const HeaderField* const field = of_space ? of_space : fields.find("units");
  std::vector<std::string> units = field ? quotedTexts(fields, *field) : std::vector<std::string>();
  AxisUnits out;
  if (units.empty()) return out;
  units.resize(3, units.front());
  const std::string name = unitName(units[0]);
  out.unit = name.empty() ? units[0] : name;
  for (std::size_t axis = 1; axis < 3; ++axis) {
    const std::optional<LengthRatio> ratio = lengthRatio(units[axis], units[0]);
    const bool legal = of_space || !fields.find("space directions") || ratio == LengthRatio();
    if (ratio && legal) out.to_unit[axis] = *ratio;
    if (!ratio || !legal)
      notes.push_back(
          fmt::format("lengths along {} are in {} and along x in {}, and cannot be converted; they are taken as equal",
                      "xyz"[axis], inQuotes(units[axis]), inQuotes(units[0])));
  }
  return out;
}

// Builds the affine from spacings and ranges of the axes, for headers without directions.
glm::dmat4 affineOfAxes(const HeaderFields& fields, const Extent3& dims, const AxisUnits& units,
                        const SourceOptions& options) {
  const auto optional = [&](const char* key) {
    const HeaderField* field = fields.find(key);
    return field ? units.of(fields.vector(*field)) : glm::dvec3(std::nan(""));
  };
  const glm::dvec3 mins = optional("axis mins"), maxs = optional("axis maxs");
  glm::dvec3 spacing = optional("spacings"), origin(0);
  const HeaderField* centers = fields.find("centers");
  const std::vector<std::string> kinds = centers ? words(lowered(centers->value)) : std::vector<std::string>(3);
  if (kinds.size() != 3) fields.fail(*centers, "one word an axis is expected");
  for (int axis = 0; axis < 3; ++axis) {
    const bool cell = kinds[axis] == "cell";
    const double steps = static_cast<double>(cell ? dims[axis] : dims[axis] - 1);
    // The spacing implied by the axis range, if the header gives a range only. NaN means "unknown" and becomes 1.
    if (std::isnan(spacing[axis]) && steps > 0) spacing[axis] = (maxs[axis] - mins[axis]) / steps;
    if (std::isnan(spacing[axis])) spacing[axis] = 1;
    if (options.spacing) spacing[axis] = (*options.spacing)[axis];
    // The range of a cell-centred axis starts at the first cell's face; of a node-centred axis at the first sample.
    if (!std::isnan(mins[axis])) origin[axis] = mins[axis] + (cell ? spacing[axis] / 2 : 0);
  }
  if (const HeaderField* field = fields.find("space origin")) origin = units.of(vectorsOf(fields, *field, 1)[0]);
  return axesAffine(spacing, origin);
}

}  // namespace

VolumeGeometry nrrdGeometry(const HeaderFields& fields, const SourceOptions& options, std::vector<std::string>& notes) {
  VolumeGeometry geometry;
  geometry.dims = fields.extent(fields.require("sizes"));
  const AxisUnits units = unitsOf(fields, notes);
  geometry.unit = units.unit;
  bool mirror_x = false;
  geometry.frame = frameOf(fields, mirror_x);
  const HeaderField* directions = fields.find("space directions");
  if (directions) {
    if (options.spacing) {
      throw Error(ErrorCode::kUsage, fields.path(), "line " + std::to_string(directions->line),
                  "--spacing does not apply: the file gives its axes in 'space directions'");
    }
    for (const char* key : {"spacings", "axis mins", "axis maxs"}) {
      const HeaderField* other = fields.find(key);
      if (!other) continue;
      const glm::dvec3 v = fields.vector(*other);
      const bool all_nan = std::isnan(v.x) && std::isnan(v.y) && std::isnan(v.z);
      if (!all_nan) fields.fail(*other, "contradicts 'space directions' in line " + std::to_string(directions->line));
    }
    const std::vector<glm::dvec3> v = vectorsOf(fields, *directions, 3);
    const HeaderField* origin = fields.find("space origin");
    geometry.world_from_index = directionsAffine({units.of(v[0]), units.of(v[1]), units.of(v[2])},
                                                 origin ? units.of(vectorsOf(fields, *origin, 1)[0]) : glm::dvec3(0));
  } else {
    geometry.world_from_index = affineOfAxes(fields, geometry.dims, units, options);
  }
  if (mirror_x) {
    for (int column = 0; column < 4; ++column) geometry.world_from_index[column].x *= -1;
  }
  requireInvertible(geometry.world_from_index, fields.path().string());
  return geometry;
}

}  // namespace kiln
