#include "ingest/chunks/array_volume.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/error.h"
#include "base/text.h"
#include "ingest/source/header_text.h"
#include "ingest/source/length_unit.h"

namespace kiln {
namespace {

constexpr const char* kNamesOfSpace[] = {"x", "y", "z"};

int axisNamed(const std::vector<ArrayAxis>& axes, std::string_view name) {
  const auto found = std::find_if(axes.begin(), axes.end(), [&](const ArrayAxis& axis) { return axis.name == name; });
  return found == axes.end() ? -1 : static_cast<int>(found - axes.begin());
}

std::string shown(const AxisNumbers& shape) { return fmt::format("({})", fmt::join(shape, ", ")); }

// Names the axes of an array without names: the last three are z, y, x, as all writers order them.
void nameAxes(const ArrayName& array, const SourceOptions& options, std::vector<ArrayAxis>& axes) {
  const auto named = [](const ArrayAxis& axis) { return !axis.name.empty(); };
  if (std::any_of(axes.begin(), axes.end(), named)) return;
  const char* const with_time[] = {"x", "y", "z", options.time && !options.channel ? "t" : "c",
                                   options.time && !options.channel ? "c" : "t"};
  for (std::size_t i = 0; i < axes.size() && i < 5; ++i) axes[axes.size() - 1 - i].name = with_time[i];
  if (array.shape.size() < 2)
    throw Error(ErrorCode::kUnsupported, array.header, "shape",
                fmt::format("{} has one axis; a volume has three", shown(array.shape)));
}

void requireIndex(const ArrayName& array, const char* option, std::int64_t index, std::int64_t count) {
  if (index >= 0 && index < count) return;
  throw Error(ErrorCode::kUsage, array.input, option,
              count == 1 ? fmt::format("there is only number 0 (found {})", index)
                         : fmt::format("must be a number from 0 to {} (found {})", count - 1, index));
}

std::string listOf(const std::vector<ArrayChannel>& channels) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < channels.size(); ++i)
    names.push_back(channels[i].name.empty() ? std::to_string(i) : fmt::format("{} {}", i, inQuotes(channels[i].name)));
  return fmt::format("{}", fmt::join(names, ", "));
}

std::int64_t channelIndex(const ArrayName& array, std::int64_t count, const std::vector<ArrayChannel>& channels,
                          const std::optional<std::string>& chosen) {
  if (!chosen) {
    if (count == 1) return 0;
    throw Error(ErrorCode::kUsage, array.input, "--channel",
                fmt::format("there are {} channels{}; choose one, as --channel 0", count,
                            channels.empty() ? "" : " (" + listOf(channels) + ")"));
  }
  for (std::size_t i = 0; i < channels.size() && static_cast<std::int64_t>(i) < count; ++i)
    if (channels[i].name == *chosen) return static_cast<std::int64_t>(i);
  const std::optional<std::int64_t> number = decimalOf<std::int64_t>(*chosen);
  if (!number)
    throw Error(ErrorCode::kUsage, array.input, "--channel",
                fmt::format("no channel has the name {}{}", inQuotes(*chosen),
                            channels.empty() ? "; give a number from 0" : "; there are " + listOf(channels)));
  requireIndex(array, "--channel", *number, count);
  return *number;
}

std::int64_t timeIndex(const ArrayName& array, std::int64_t count, const std::optional<std::int64_t>& chosen) {
  if (!chosen && count > 1)
    throw Error(ErrorCode::kUsage, array.input, "--time",
                fmt::format("there are {} times; choose one, as --time 0", count));
  if (chosen) requireIndex(array, "--time", *chosen, count);
  return chosen.value_or(0);
}

// Fixes the index along every axis but x, y and z.
void chooseIndices(const ArrayName& array, const std::vector<ArrayAxis>& axes,
                   const std::vector<ArrayChannel>& channels, const SourceOptions& options, ArrayVolume& out) {
  out.fixed.assign(array.shape.size(), 0);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::string& name = axes[i].name;
    const std::int64_t count = array.shape[i];
    if (std::find(std::begin(kNamesOfSpace), std::end(kNamesOfSpace), name) != std::end(kNamesOfSpace)) continue;
    if (name == "c") {
      out.fixed[i] = channelIndex(array, count, channels, options.channel);
      if (count > 1) out.choice += fmt::format(", channel {}", out.fixed[i]);
    } else if (name == "t") {
      out.fixed[i] = timeIndex(array, count, options.time);
      if (count > 1) out.choice += fmt::format(", time {}", out.fixed[i]);
    } else if (count > 1) {
      throw Error(ErrorCode::kUnsupported, array.header, "shape",
                  fmt::format("the axis {} of {} has {} entries, and is neither x, y, z, a channel nor a time",
                              name.empty() ? std::to_string(i) : inQuotes(name), shown(array.shape), count));
    }
  }
  if (options.channel && axisNamed(axes, "c") < 0) channelIndex(array, 1, channels, options.channel);
  if (options.time && axisNamed(axes, "t") < 0) requireIndex(array, "--time", *options.time, 1);
}

// RFC-4 of OME-Zarr: the anatomical direction of growing indices, in RAS.
std::optional<glm::dvec3> directionOf(const std::string& orientation) {
  const std::pair<const char*, glm::dvec3> kDirections[] = {
      {"left-to-right", {1, 0, 0}},          {"right-to-left", {-1, 0, 0}},       {"posterior-to-anterior", {0, 1, 0}},
      {"anterior-to-posterior", {0, -1, 0}}, {"inferior-to-superior", {0, 0, 1}}, {"superior-to-inferior", {0, 0, -1}}};
  for (const auto& [name, direction] : kDirections)
    if (orientation == name) return direction;
  return std::nullopt;
}

// Returns the directions of x, y and z in the world; nothing unless all three are anatomical and independent.
std::optional<glm::dmat3> anatomy(const std::array<const ArrayAxis*, 3>& axes) {
  glm::dmat3 out(0.0);
  for (int i = 0; i < 3; ++i) {
    const std::optional<glm::dvec3> direction = axes[i] ? directionOf(axes[i]->orientation) : std::nullopt;
    if (!direction) return std::nullopt;
    out[i] = *direction;
  }
  return std::abs(glm::determinant(out)) == 1 ? std::optional(out) : std::nullopt;
}

void placeInWorld(const std::vector<ArrayAxis>& axes, bool has_scale, const SourceOptions& options, ArrayVolume& out) {
  std::array<const ArrayAxis*, 3> space{};
  for (int i = 0; i < 3; ++i)
    if (out.axis_of[i] >= 0) space[i] = &axes[static_cast<std::size_t>(out.axis_of[i])];
  glm::dvec3 scale(1), origin(0);
  std::string unit = space[0] ? space[0]->unit : "";
  for (int i = 0; i < 3; ++i) {
    if (!space[i]) continue;
    const std::optional<UnitRatio> ratio = unitRatio(space[i]->unit, unit);
    if (!ratio)
      out.notes.push_back(
          fmt::format("lengths along {} are in {} and along x in {}, of which one is unknown; they are "
                      "taken as equal; --spacing sets another size",
                      kNamesOfSpace[i], inQuotes(space[i]->unit), inQuotes(unit)));
    const UnitRatio in_x = ratio.value_or(UnitRatio());
    scale[i] = in_x.of(space[i]->scale);
    origin[i] = in_x.of(space[i]->translation);
  }
  out.geometry.unit = unitName(unit);
  if (!unit.empty() && out.geometry.unit.empty())
    out.notes.push_back(fmt::format("the unit {} is unknown; lengths are taken without a unit", inQuotes(unit)));
  if (options.spacing) scale = *options.spacing;
  if (!has_scale && !options.spacing)
    out.notes.push_back(
        "the metadata give no size of a voxel; voxels are taken as 1 x 1 x 1; --spacing sets another size");
  out.geometry.world_from_index = axesAffine(scale, origin);
  if (const std::optional<glm::dmat3> directions = anatomy(space)) {
    out.geometry.world_from_index = glm::dmat4(*directions) * out.geometry.world_from_index;
    out.geometry.frame = PatientFrame::kRas;
  }
}

}  // namespace

ArrayVolume volumeOf(const ArrayName& array, std::vector<ArrayAxis> axes, bool has_scale,
                     const std::vector<ArrayChannel>& channels, const SourceOptions& options) {
  axes.resize(array.shape.size());
  nameAxes(array, options, axes);
  ArrayVolume out;
  glm::i64vec3 dims(1);
  int found = 0;
  for (int i = 0; i < 3; ++i) {
    out.axis_of[i] = axisNamed(axes, kNamesOfSpace[i]);
    if (out.axis_of[i] < 0) continue;
    dims[i] = array.shape[static_cast<std::size_t>(out.axis_of[i])];
    ++found;
  }
  if (found < 2)
    throw Error(ErrorCode::kUnsupported, array.header, "axes",
                fmt::format("the array {} has no axes x, y and z", shown(array.shape)));
  out.geometry.dims = {dims.x, dims.y, dims.z};
  chooseIndices(array, axes, channels, options, out);
  placeInWorld(axes, has_scale, options, out);
  requireInvertible(out.geometry.world_from_index, array.header.string());
  return out;
}

}  // namespace kiln
