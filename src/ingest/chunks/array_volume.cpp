#include "ingest/chunks/array_volume.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/error.h"
#include "base/text.h"
#include "grid/length_unit.h"
#include "ingest/source/chosen_part.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

constexpr const char* kNamesOfSpace[] = {"x", "y", "z"};

int axisNamed(const std::vector<ArrayAxis>& axes, std::string_view name) {
  const auto found = std::find_if(axes.begin(), axes.end(), [&](const ArrayAxis& axis) { return axis.name == name; });
  return found == axes.end() ? -1 : static_cast<int>(found - axes.begin());
}

std::string shownShape(const AxisNumbers& shape) { return fmt::format("({})", fmt::join(shape, ", ")); }

bool isTimeOrChannel(const ArrayAxis& axis) { return axis.name == "t" || axis.name == "c"; }

bool isSpace(const ArrayAxis& axis) {
  return std::find(std::begin(kNamesOfSpace), std::end(kNamesOfSpace), axis.name) != std::end(kNamesOfSpace);
}

void requireOneAxisOfAName(const ArrayName& array, const std::vector<ArrayAxis>& axes) {
  for (std::size_t i = 0; i < axes.size(); ++i)
    if (!axes[i].name.empty() && axisNamed(axes, axes[i].name) != static_cast<int>(i))
      throw Error(ErrorCode::kFormat, array.header, "axes",
                  fmt::format("two axes have the name {}; write different names", inQuotes(axes[i].name)));
}

// The axes behind x: a channel of one entry, which programs write that store channels last.
std::ptrdiff_t axesBehindX(const AxisNumbers& shape, const std::vector<ArrayAxis>& axes) {
  std::ptrdiff_t out = 0;
  for (std::size_t i = axes.size(); i-- > 3 && shape[i] == 1 && axes[i].name.empty();) ++out;
  return out;
}

// Names the axes of space. If x, y and z are known, axes without a name become channels and times, the last one first.
void nameByPlace(const ArrayName& array, const SourceOptions& options, std::vector<ArrayAxis>& axes,
                 std::vector<std::string>& notes) {
  if (array.shape.size() < 2)
    throw Error(ErrorCode::kUnsupported, array.header, "shape",
                fmt::format("{} has fewer than two axes; a volume has three", shownShape(array.shape)));
  const std::array<int, 3> space = spaceAxes(array.shape, axes);
  std::vector<std::string> taken;
  for (std::size_t i = 0; i < space.size(); ++i) {
    if (space[i] < 0) continue;
    std::string& name = axes[static_cast<std::size_t>(space[i])].name;
    if (name != kNamesOfSpace[i] && !name.empty())
      taken.push_back(fmt::format("{} as {}", inQuotes(name), kNamesOfSpace[i]));
    name = kNamesOfSpace[i];
  }
  if (!taken.empty()) notes.push_back(fmt::format("took the axes {}", fmt::join(taken, ", ")));
  if (std::find(space.begin(), space.end(), -1) != space.end()) return;
  std::vector<const char*> names;
  const bool only_time = options.time && !options.channel;
  for (const char* const name : {only_time ? "t" : "c", only_time ? "c" : "t"})
    if (axisNamed(axes, name) < 0) names.push_back(name);
  auto next = names.begin();
  for (auto axis = axes.rbegin() + axesBehindX(array.shape, axes); axis != axes.rend() && next != names.end(); ++axis) {
    if (isSpace(*axis) || isTimeOrChannel(*axis)) continue;
    // A name that is no name of space must not become a channel.
    if (!axis->name.empty()) break;
    axis->name = *next++;
  }
}

// The names of `count` channels.
std::vector<std::string> channelNames(const ArrayName& array, std::int64_t count,
                                      const std::vector<std::string>& channels) {
  constexpr std::int64_t kMostChannels = 1 << 16;
  if (count > kMostChannels)
    throw Error(ErrorCode::kUnsupported, array.header, "shape",
                fmt::format("{} has more than {} channels", shownShape(array.shape), kMostChannels));
  std::vector<std::string> out(static_cast<std::size_t>(count));
  std::copy_n(channels.begin(), std::min(out.size(), channels.size()), out.begin());
  return out;
}

// Fixes the index along every axis but x, y and z.
void chooseIndices(const ArrayName& array, const std::vector<ArrayAxis>& axes, const std::vector<std::string>& channels,
                   const SourceOptions& options, ArrayVolume& out) {
  out.fixed.assign(array.shape.size(), 0);
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const std::string& name = axes[i].name;
    const std::int64_t count = array.shape[i];
    if (isSpace(axes[i])) continue;
    if (name == "c") {
      out.fixed[i] = chosenChannel(options, channelNames(array, count, channels), array.input);
      out.channel = out.fixed[i];
      out.choice += partOf("channel", out.fixed[i], count);
    } else if (name == "t") {
      out.fixed[i] = chosenTime(options, count, array.input);
      out.choice += partOf("time", out.fixed[i], count);
    } else if (count > 1) {
      throw Error(ErrorCode::kUnsupported, array.header, "shape",
                  fmt::format("the axis {} of {} has {} entries, and is neither x, y, z, a channel nor a time",
                              name.empty() ? std::to_string(i) : inQuotes(name), shownShape(array.shape), count));
    }
  }
  if (axisNamed(axes, "c") < 0) chosenChannel(options, channelNames(array, 1, channels), array.input);
  if (axisNamed(axes, "t") < 0) chosenTime(options, 1, array.input);
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
    const std::optional<LengthRatio> ratio = lengthRatio(space[i]->unit, unit);
    if (!ratio)
      out.notes.push_back(
          fmt::format("lengths along {} are in {} and along x in {}, of which one is unknown; they are "
                      "taken as equal; --spacing sets another size",
                      kNamesOfSpace[i], inQuotes(space[i]->unit), inQuotes(unit)));
    const LengthRatio in_x = ratio.value_or(LengthRatio());
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

std::string plainAxisName(const std::string& name) {
  const std::string small = lowered(name);
  if (small == "channel" || small == "channels") return "c";
  return small == "time" ? "t" : small;
}

std::array<int, 3> spaceAxes(const AxisNumbers& shape, const std::vector<ArrayAxis>& axes) {
  std::array<int, 3> out = {-1, -1, -1};
  if (std::any_of(axes.begin(), axes.end(), isSpace)) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = axisNamed(axes, kNamesOfSpace[i]);
    return out;
  }
  std::size_t next = 0;
  for (auto i = static_cast<int>(std::ssize(axes) - axesBehindX(shape, axes)); i-- > 0 && next < out.size();)
    if (!isTimeOrChannel(axes[static_cast<std::size_t>(i)])) out[next++] = i;
  return out;
}

ArrayVolume volumeOf(const ArrayName& array, std::vector<ArrayAxis> axes, bool has_scale,
                     const std::vector<std::string>& channels, const SourceOptions& options) {
  axes.resize(array.shape.size());
  for (ArrayAxis& axis : axes) axis.name = plainAxisName(axis.name);
  requireOneAxisOfAName(array, axes);
  ArrayVolume out;
  nameByPlace(array, options, axes, out.notes);
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
                fmt::format("the array {} has no axes x, y and z", shownShape(array.shape)));
  out.geometry.dims = {dims.x, dims.y, dims.z};
  chooseIndices(array, axes, channels, options, out);
  placeInWorld(axes, has_scale, options, out);
  requireInvertible(out.geometry.world_from_index, array.header.string());
  return out;
}

std::string noteOfScaled(double factor, double offset) {
  if (factor == 1 && offset == 0) return "";
  return fmt::format(
      "the attributes say that values are {} + {} times the stored numbers; the numbers are taken as stored", offset,
      factor);
}

void describe(const ArrayVolume& volume, VoxelType type, SourceInfo& info) {
  info.type = type;
  info.geometry = volume.geometry;
  info.volume_class = volume.volume_class;
  info.look = volume.look;
  info.format += volume.choice;
  info.notes.insert(info.notes.end(), volume.notes.begin(), volume.notes.end());
}

}  // namespace kiln
