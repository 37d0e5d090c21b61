// Problem. Programs describe the axes of a data set in different attributes and data sets around it.
// Method. Names are those of the first source that names each axis: NeXus, labels of h5py, tags of vigra (ilastik),
// dim1, dim2 … of EMD, dimension scales of HDF5 (NetCDF). Sizes are element_size_um (ilastik), else the mean distance
// of coordinates. Source: manual.nexusformat.org, NXdata; emdatasets.com, the EMD format; docs.hdfgroup.org, the HDF5
// Dimension Scale Specification.
#include "ingest/hdf5/hdf5_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "base/error.h"
#include "base/text.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

// EMD writes nanometres as "[n_m]".
std::string unitOf(const Hdf5Object& coordinates) {
  std::string out = coordinates.text("units").value_or("");
  std::erase_if(out, [](char c) { return c == '[' || c == ']' || c == '_'; });
  return out;
}

// The legal lengths of a list of coordinates: a number for each voxel, or also another length.
enum class Coordinates { kOfVoxels, kOrFirstTwo, kOrEdges };

// The names of axes, none or one for each, and the paths of their coordinates, which may lead nowhere.
struct AxisWords {
  std::vector<std::string> names, coordinates;
  Coordinates rule = Coordinates::kOfVoxels;
};

// Gives an axis the mean distance, the begin and the unit of its coordinates, which may fall.
bool placeAxis(const std::string& path, const Hdf5Object& coordinates, bool are_edges, ArrayAxis& axis,
               std::vector<std::string>& notes) {
  const std::vector<double>& at = coordinates.values;
  if (at.size() < 2) return false;
  const double step = (at.back() - at.front()) / static_cast<double>(at.size() - 1);
  if (step == 0 || !std::isfinite(step)) return false;
  axis.scale = step;
  axis.translation = at.front() + (are_edges ? step / 2 : 0);
  axis.unit = unitOf(coordinates);
  bool equal = true;
  for (std::size_t i = 0; i < at.size(); ++i)
    equal = equal && std::abs(at.front() + step * static_cast<double>(i) - at[i]) <= std::abs(step) * 1e-3;
  if (!equal)
    notes.push_back(
        fmt::format("the coordinates {} are not equally spaced; their mean distance, {:.6g}{}, is used; "
                    "--spacing sets another size",
                    shown(path), step, axis.unit.empty() ? "" : " " + axis.unit));
  return true;
}

bool isForAxis(const Hdf5Object* coordinates, std::int64_t voxels, Coordinates rule) {
  if (!coordinates) return false;
  const auto count = static_cast<std::int64_t>(coordinates->values.size());
  return count == voxels || (rule == Coordinates::kOrFirstTwo && count == 2) ||
         (rule == Coordinates::kOrEdges && count == voxels + 1);
}

// NeXus: a list of the group, or, before 2014, a text of the data set, "[z:y:x]" or "z,y,x".
std::vector<std::string> nexusNames(const Hdf5Object* group, const Hdf5Object& dataset) {
  std::vector<std::string> out = group ? group->texts("axes") : std::vector<std::string>();
  std::string text = dataset.text("axes").value_or("");
  if (out.size() == dataset.shape.size() || text.empty()) return out;
  std::erase_if(text, [](char c) { return c == '[' || c == ']' || c == ' '; });
  const std::vector<std::string_view> names = splitAt(text, text.find(':') == std::string::npos ? ',' : ':');
  return {names.begin(), names.end()};
}

// Returns all of a program's free names if x, y and z are among them; else only times and channels beside three
// other axes; none if no name is left.
std::vector<std::string> freeNames(std::vector<std::string> names) {
  for (std::string& name : names) name = plainAxisName(name);
  const auto has = [&](const char* name) { return std::count(names.begin(), names.end(), name) == 1; };
  if (has("x") && has("y") && has("z")) return names;
  const auto is_named = [](const std::string& name) { return name == "t" || name == "c"; };
  const auto named = std::count_if(names.begin(), names.end(), is_named);
  if (named == 0 || named + 3 > std::ssize(names)) return {};
  for (std::string& name : names)
    if (!is_named(name)) name.clear();
  return names;
}

// EMD: attributes of dim1, dim2, ….
std::vector<std::string> emdNames(const Hdf5Objects& objects, const std::string& group, std::size_t axes) {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < axes; ++i) {
    const Hdf5Object* const dim = objects.find(group + fmt::format("/dim{}", i + 1));
    out.push_back(dim ? dim->text("name").value_or("") : "");
  }
  return freeNames(std::move(out));
}

// The axis tags of vigra, which ilastik writes: {"axes": [{"key": "z"}, …]}. Returns none, with a note, unless the tags
// are a name for each axis: tags are not needed to read the data set.
std::vector<std::string> vigraNames(const Hdf5Object& dataset, const std::string& path,
                                    std::vector<std::string>& notes) {
  const std::optional<std::string> tags = dataset.text("axistags");
  if (!tags) return {};
  std::vector<std::string> out;
  std::set<std::string> different;
  try {
    const JsonNode json(dataset.attributes.file(), *tags, UINT64_MAX);
    for (const JsonNode& axis : json.at("axes").items(32)) out.push_back(axis.at("key").text());
    for (const std::string& name : out) different.insert(plainAxisName(name));
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kFormat) throw;
  }
  if (different.size() == dataset.shape.size() && out.size() == different.size()) return out;
  notes.push_back(fmt::format("the attribute axistags of {} does not name the {} axes one by one and is ignored",
                              shown(path), dataset.shape.size()));
  return {};
}

// Dimension scales of HDF5, which NetCDF names as its dimensions.
std::vector<std::string> scaleNames(const Hdf5Object& dataset) {
  std::vector<std::string> out;
  for (const std::string& path : dataset.scales) out.push_back(path.substr(path.find_last_of('/') + 1));
  return freeNames(std::move(out));
}

AxisWords axisWords(const Hdf5Objects& objects, const std::string& path, std::vector<std::string>& notes) {
  const Hdf5Object& dataset = *objects.find(path);
  const std::size_t count = dataset.shape.size();
  const std::string group = parentOf(path);
  const Hdf5Object* const above = objects.find(group.empty() ? "/" : group);
  AxisWords out;
  out.names = nexusNames(above, dataset);
  if (out.names.size() == count) {
    out.rule = Coordinates::kOrEdges;
    for (std::string& name : out.names) {
      out.coordinates.push_back(group + "/" + name);
      // NeXus: an axis without coordinates.
      if (name == ".") name.clear();
    }
    return out;
  }
  out.names = dataset.texts("DIMENSION_LABELS");
  if (out.names.size() != count) out.names = vigraNames(dataset, path, notes);
  if (out.names.size() != count) out.names = emdNames(objects, group, count);
  if (out.names.size() != count) out.names = scaleNames(dataset);
  if (out.names.size() != count) out.names.clear();
  out.coordinates = dataset.scales;
  if (out.coordinates.size() == count) return out;
  out.rule = Coordinates::kOrFirstTwo;
  out.coordinates.clear();
  for (std::size_t i = 0; i < count; ++i) out.coordinates.push_back(group + fmt::format("/dim{}", i + 1));
  return out;
}

// Sets the size of a voxel along z, y and x, as ilastik writes it, of the axes x, y and z, -1 for a missing axis.
// Returns false if the data set has no such sizes.
bool placeByElementSize(const Hdf5Object& dataset, const std::array<int, 3>& space, std::vector<ArrayAxis>& axes) {
  const std::vector<double> sizes = dataset.numbers("element_size_um");
  if (sizes.size() != 3 || !std::all_of(sizes.begin(), sizes.end(), [](double s) { return s > 0; })) return false;
  for (std::size_t i = 0; i < space.size(); ++i) {
    if (space[i] < 0) continue;
    ArrayAxis& axis = axes[static_cast<std::size_t>(space[i])];
    axis.scale = sizes[2 - i];
    axis.unit = "um";
  }
  return true;
}

// An axis of space, and the list of its coordinates, which may be missing or of another length.
struct SpaceAxis {
  std::size_t axis = 0;
  std::int64_t voxels = 0;
  std::string path;
  const Hdf5Object* list = nullptr;
};

// The axes of space in the order of the array.
std::vector<SpaceAxis> coordinatesOfSpace(const Hdf5Objects& objects, const AxisWords& words, const AxisNumbers& shape,
                                          const std::array<int, 3>& space) {
  std::vector<SpaceAxis> out;
  for (std::size_t i = 0; i < shape.size(); ++i)
    if (std::find(space.begin(), space.end(), static_cast<int>(i)) != space.end())
      out.push_back({i, shape[i], words.coordinates[i], objects.find(words.coordinates[i])});
  return out;
}

// Sets sizes and places by coordinates. Notes coordinates that are not used and axes without coordinates.
void placeByCoordinates(const std::vector<SpaceAxis>& space, Coordinates rule, Hdf5Image& out) {
  std::vector<std::size_t> unplaced;
  const ArrayAxis* placed = nullptr;
  for (const SpaceAxis& each : space) {
    const bool fits = isForAxis(each.list, each.voxels, rule);
    const bool edges = fits && rule == Coordinates::kOrEdges && std::ssize(each.list->values) == each.voxels + 1;
    ArrayAxis& axis = out.axes[each.axis];
    const bool has_place = fits && placeAxis(each.path, *each.list, edges, axis, out.notes);
    if (each.list && !each.list->values.empty() && !fits)
      out.notes.push_back(fmt::format("the coordinates {} are {} numbers for {} voxels and are not used",
                                      shown(each.path), each.list->values.size(), each.voxels));
    if (has_place && !placed) placed = &axis;
    if (!has_place) unplaced.push_back(each.axis);
  }
  out.has_scale = placed != nullptr;
  for (const std::size_t i : placed ? unplaced : std::vector<std::size_t>()) {
    ArrayAxis& axis = out.axes[i];
    axis.unit = placed->unit;
    out.notes.push_back(fmt::format(
        "no coordinates give a distance along the axis {}, which is taken as {}; --spacing sets another size",
        axis.name.empty() ? std::to_string(i) : inQuotes(axis.name), axis.unit.empty() ? "1" : "1 " + axis.unit));
  }
}

// Element sizes count, because one attribute gives all three.
void noteUnusedCoordinates(const std::vector<SpaceAxis>& space, std::vector<std::string>& notes) {
  for (const SpaceAxis& each : space)
    if (each.list && !each.list->values.empty())
      notes.push_back(
          fmt::format("element_size_um gives the size of a voxel; the coordinates {} are not used", shown(each.path)));
}

}  // namespace

void describeAxes(const Hdf5Objects& objects, Hdf5Image& out) {
  const Hdf5Object& dataset = *objects.find(out.path);
  const AxisWords words = axisWords(objects, out.path, out.notes);
  out.axes.resize(dataset.shape.size());
  for (std::size_t i = 0; i < words.names.size(); ++i) out.axes[i].name = plainAxisName(words.names[i]);
  const std::array<int, 3> axes_of_space = spaceAxes(dataset.shape, out.axes);
  const std::vector<SpaceAxis> space = coordinatesOfSpace(objects, words, dataset.shape, axes_of_space);
  out.has_scale = placeByElementSize(dataset, axes_of_space, out.axes);
  if (out.has_scale)
    noteUnusedCoordinates(space, out.notes);
  else
    placeByCoordinates(space, words.rule, out);
  const std::string note =
      noteOfScaled(dataset.number("scale_factor").value_or(1), dataset.number("add_offset").value_or(0));
  if (!note.empty()) out.notes.push_back(note);
}

}  // namespace kiln
