#include "ingest/hdf5/hdf5_image.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "base/file/path_status.h"
#include "base/text.h"
#include "grid/value_range.h"
#include "ingest/hdf5/bdv_xml.h"
#include "ingest/hdf5/hdf5_axes.h"
#include "ingest/source/chosen_part.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

[[noreturn]] void failOption(const fs::path& file, const char* option, const std::string& what) {
  throw Error(ErrorCode::kUsage, file, option, what);
}

// The number of paths `pattern` with 0, 1, 2, … that exist.
template <class Path>
std::int64_t countOf(const Hdf5Objects& objects, Path path) {
  std::int64_t n = 0;
  while (n < 1'000'000 && objects.find(path(n)) != nullptr) ++n;
  return n;
}

// Describes all below `group` if objects may be missing from the first description; else returns nothing.
std::optional<Hdf5Objects> missingBelow(const std::string& group, const Hdf5Objects& first,
                                        const DescribeHdf5& describe) {
  return first.areOthersCut() ? std::optional(describe(group)) : std::nullopt;
}

// Imaris: /DataSet/ResolutionLevel R/TimePoint T/Channel C/Data. Source: the description of Imaris 5.5 files.
bool isImarisData(const std::string& path, const Hdf5Objects& objects) {
  return path.starts_with("/DataSet/ResolutionLevel ") && path.ends_with("/Data") && objects.find(parentOf(path)) &&
         objects.find("/DataSetInfo/Image");
}

Hdf5Image ofImarisData(const fs::path& file, const Hdf5Objects& objects, const std::string& path) {
  Hdf5Image out;
  out.path = path;
  out.choice = ", Imaris";
  if (!objects.hasDataset(out.path)) throw Error(ErrorCode::kFormat, file, out.path, "is missing in this Imaris file");
  const AxisNumbers& shape = objects.find(out.path)->shape;
  if (shape.size() != 3) throw Error(ErrorCode::kFormat, file, out.path, "must have three axes");
  const Hdf5Object *const sizes = objects.find(parentOf(path)), *const image = objects.find("/DataSetInfo/Image");
  const char* const axis_names[] = {"z", "y", "x"};
  out.used_shape = shape;
  out.axes.resize(3);
  for (int i = 0; i < 3; ++i) {
    const int imaris_axis = 2 - i;
    const char letter = static_cast<char>('X' + imaris_axis);
    const std::optional<double> size = sizes->number(fmt::format("ImageSize{}", letter));
    if (size && *size >= 1 && *size <= static_cast<double>(shape[i]))
      out.used_shape[i] = static_cast<std::int64_t>(*size);
    out.axes[i].name = axis_names[i];
    const auto extent = [&](const char* end) {
      return image ? image->number(fmt::format("Ext{}{}", end, imaris_axis)) : std::nullopt;
    };
    const std::optional<double> low = extent("Min"), high = extent("Max");
    if (!low || !high || !(*high > *low)) continue;
    // Extents go from the outer side of the first voxel to that of the last.
    out.axes[i].scale = (*high - *low) / static_cast<double>(out.used_shape[i]);
    out.axes[i].translation = *low + out.axes[i].scale / 2;
    out.axes[i].unit = image->text("Unit").value_or("um");
    out.has_scale = true;
  }
  return out;
}

Hdf5Image ofImaris(const fs::path& file, const Hdf5Objects& first, const DescribeHdf5& describe,
                   const SourceOptions& options) {
  const auto level = [](std::int64_t r) { return fmt::format("/DataSet/ResolutionLevel {}", r); };
  const std::int64_t scale = chosenScale(options, std::max<std::int64_t>(countOf(first, level), 1), file);
  const std::optional<Hdf5Objects> more = missingBelow(level(scale), first, describe);
  const Hdf5Objects& objects = more ? *more : first;
  const auto time_path = [&](std::int64_t t) { return fmt::format("{}/TimePoint {}", level(scale), t); };
  const std::int64_t time = chosenTime(options, countOf(objects, time_path), file);
  const auto channel_path = [&](std::int64_t c) { return fmt::format("{}/Channel {}", time_path(time), c); };
  std::vector<std::string> names(static_cast<std::size_t>(countOf(objects, channel_path)));
  for (std::size_t c = 0; c < names.size(); ++c) {
    const Hdf5Object* const info = objects.find(fmt::format("/DataSetInfo/Channel {}", c));
    names[c] = info ? info->text("Name").value_or("") : "";
  }
  const std::int64_t channel = chosenChannel(options, names, file);
  Hdf5Image out = ofImarisData(file, objects, channel_path(channel) + "/Data");
  out.path_chooses = true;
  out.choice += fmt::format(", resolution {}, time {}, channel {}", scale, time, channel);
  return out;
}

// BigDataViewer: /tTTTTT/sSS/L/cells, with an XML file beside it. Source: imagej.net/plugins/bdv, "About the
// BigDataViewer data format".
struct BdvCells {
  std::int64_t time = 0, setup = 0, scale = 0;

  static std::string timeGroup(std::int64_t time) { return fmt::format("/t{:05}", time); }
  std::string setupGroup() const { return fmt::format("/s{:02}", setup); }
  std::string scaleGroup() const { return fmt::format("{}{}/{}", timeGroup(time), setupGroup(), scale); }
  std::string path() const { return scaleGroup() + "/cells"; }
};

// Returns the numbers in a path of cells; nothing for a data set of another program.
std::optional<BdvCells> bdvCellsAt(const std::string& path, const Hdf5Objects& objects) {
  const std::vector<std::string_view> parts = splitAt(path, '/');
  if (parts.size() != 5 || parts[1].size() < 2 || parts[2].size() < 2) return std::nullopt;
  const auto time = numberOf<std::int64_t>(parts[1].substr(1)), setup = numberOf<std::int64_t>(parts[2].substr(1)),
             scale = numberOf<std::int64_t>(parts[3]);
  if (!time || !setup || !scale) return std::nullopt;
  const BdvCells out{*time, *setup, *scale};
  const bool is_bdv = out.path() == path && objects.find(out.setupGroup() + "/resolutions") != nullptr;
  return is_bdv ? std::optional(out) : std::nullopt;
}

Hdf5Image ofBdvCells(const fs::path& file, const Hdf5Objects& objects, const BdvCells& cells, BdvXmlBeside& beside) {
  const std::optional<BdvDescription>& xml = beside.description();
  Hdf5Image out;
  out.path = cells.path();
  out.is_unsigned = true;
  if (xml) out.headers = {beside.path()};
  out.choice = fmt::format(", BigDataViewer, time {}, setup {}, level {}", cells.time, cells.setup, cells.scale);
  if (!objects.hasDataset(out.path))
    throw Error(ErrorCode::kFormat, file, out.path, "is missing in this file of BigDataViewer");
  out.axes = {{"z", "", "", 1, 0}, {"y", "", "", 1, 0}, {"x", "", "", 1, 0}};
  // Factors of the scale, x first; a coarse voxel is centred among the voxels that it covers.
  glm::dvec3 factor(1);
  const Hdf5Object* const resolutions = objects.find(cells.setupGroup() + "/resolutions");
  for (int i = 0; i < 3 && resolutions; ++i) {
    const std::size_t at = static_cast<std::size_t>(cells.scale) * 3 + static_cast<std::size_t>(i);
    if (at < resolutions->values.size() && resolutions->values[at] >= 1) factor[i] = resolutions->values[at];
  }
  const std::optional<glm::dmat4> affine = xml ? xml->worldFromIndex(cells.time, cells.setup) : std::nullopt;
  if (affine) {
    out.world_from_index = *affine * axesAffine(factor, (factor - 1.0) / 2.0);
    out.has_scale = true;
  }
  for (ArrayAxis& axis : out.axes) axis.unit = xml ? xml->unit(cells.setup) : "";
  return out;
}

Hdf5Image ofBigDataViewer(const fs::path& file, const Hdf5Objects& first, const DescribeHdf5& describe,
                          const SourceOptions& options) {
  BdvCells cells;
  cells.time = chosenTime(options, countOf(first, &BdvCells::timeGroup), file);
  const auto setup_path = [](std::int64_t s) { return BdvCells{0, s, 0}.setupGroup(); };
  BdvXmlBeside beside(file);
  const std::optional<BdvDescription>& xml = beside.description();
  std::vector<std::string> names(static_cast<std::size_t>(countOf(first, setup_path)));
  for (std::size_t s = 0; s < names.size() && xml; ++s) names[s] = xml->setupName(static_cast<std::int64_t>(s));
  cells.setup = chosenChannel(options, names, file);
  const std::optional<Hdf5Objects> more =
      missingBelow(BdvCells::timeGroup(cells.time) + cells.setupGroup(), first, describe);
  const Hdf5Objects& objects = more ? *more : first;
  const auto scale_path = [&](std::int64_t l) { return BdvCells{cells.time, cells.setup, l}.scaleGroup(); };
  cells.scale = chosenScale(options, std::max<std::int64_t>(countOf(objects, scale_path), 1), file);
  Hdf5Image out = ofBdvCells(file, objects, cells, beside);
  out.path_chooses = true;
  return out;
}

constexpr const char* kMincImage = "/minc-2.0/image/0/image";

// The axis 0 to 2 of a dimension of MINC; -1 for other names.
int mincAxis(std::string_view name) { return name == "xspace" ? 0 : name == "yspace" ? 1 : name == "zspace" ? 2 : -1; }

// The range of whole numbers that stands for the range of values.
ValueRange validRange(const Hdf5Object& image) {
  if (const std::vector<double> range = image.numbers("valid_range"); range.size() == 2) return {range[0], range[1]};
  const bool is_signed = image.type.starts_with("int");
  const double count = std::exp2(numberOf<int>(image.type.substr(is_signed ? 3 : 4)).value_or(8));
  return is_signed ? ValueRange{-count / 2, count / 2 - 1} : ValueRange{0, count - 1};
}

// The scales of slices along the first dimension, `first`; none if all slices have the same scale.
SliceScales mincScales(const fs::path& file, const Hdf5Objects& objects, const Hdf5Object& image,
                       std::string_view first) {
  // Floats are values; their least and largest one scale nothing.
  if (image.type.starts_with("float")) return {};
  const auto find = [&](const char* name) { return objects.find(std::string("/minc-2.0/image/0/") + name); };
  const auto valuesOf = [](const Hdf5Object* scales) { return scales ? scales->values : std::vector<double>(); };
  const auto uniform = [](const Hdf5Object* scales) {
    if (!scales) return true;
    // Long lists are not described.
    const std::vector<double>& values = scales->values;
    return !values.empty() && std::all_of(values.begin(), values.end(), [&](double v) { return v == values.front(); });
  };
  const Hdf5Object *const minima = find("image-min"), *const maxima = find("image-max");
  if (uniform(minima) && uniform(maxima)) return {};
  const std::vector<double> least = valuesOf(minima), most = valuesOf(maxima);
  SliceScales out{mincAxis(first), {}};
  const ValueRange range = validRange(image);
  const auto slices = image.shape.size() == 3 ? static_cast<std::size_t>(image.shape[0]) : 0;
  if (range.lo < range.hi && out.axis >= 0 && least.size() == slices && most.size() == slices) {
    for (std::size_t i = 0; i < slices; ++i) {
      const double slope = (most[i] - least[i]) / (range.hi - range.lo);
      out.slices.push_back({slope, least[i] - range.lo * slope});
    }
    const auto legal = [](const SliceScale& s) { return std::isfinite(s.slope) && std::isfinite(s.intercept); };
    if (std::all_of(out.slices.begin(), out.slices.end(), legal)) return out;
  }
  throw Error(
      ErrorCode::kUnsupported, file, "/minc-2.0/image/0/image-max",
      "intensities are scaled slice by slice, which is read for three axes with a least and a largest value for each "
      "of at most 4096 slices; rewrite the file: mincreshape -image_range MIN MAX, or mincconvert to NIfTI");
}

// MINC 2. Source: the MINC 2.0 format's reference, and the values of its dimensions.
Hdf5Image ofMinc(const fs::path& file, const Hdf5Objects& objects) {
  Hdf5Image out;
  out.path = kMincImage;
  out.choice = ", MINC";
  out.frame = PatientFrame::kRas;
  const Hdf5Object& image = *objects.find(out.path);
  glm::dmat4 affine(1.0);
  glm::dvec3 origin(0);
  const std::string order = image.text("dimorder").value_or("zspace,yspace,xspace");
  out.scales = mincScales(file, objects, image, std::string_view(order).substr(0, order.find(',')));
  for (const std::string_view name : splitAt(order, ',')) {
    const Hdf5Object* const space = objects.find("/minc-2.0/dimensions/" + std::string(name));
    const int axis = mincAxis(name);
    out.axes.push_back({axis < 0 ? std::string(name) : std::string(1, "xyz"[axis]), "mm", "", 1, 0});
    if (axis < 0 || !space) continue;
    const double step = space->number("step").value_or(1), start = space->number("start").value_or(0);
    const std::vector<double> cosines = space->numbers("direction_cosines");
    glm::dvec3 direction(0);
    direction[axis] = 1;
    if (cosines.size() == 3) direction = {cosines[0], cosines[1], cosines[2]};
    affine[axis] = glm::dvec4(direction * step, 0);
    origin += direction * start;
  }
  affine[3] = glm::dvec4(origin, 1);
  out.world_from_index = affine;
  out.has_scale = true;
  const auto value = [&](const char* name) {
    const Hdf5Object* const scales = objects.find(std::string("/minc-2.0/image/0/") + name);
    return scales && !scales->values.empty() ? std::optional(scales->values.front()) : std::nullopt;
  };
  if (out.scales.slices.empty() && value("image-min") && value("image-max") && !image.type.starts_with("float"))
    out.notes.push_back(fmt::format("whole numbers stand for values from {} to {}; they are taken as stored",
                                    *value("image-min"), *value("image-max")));
  return out;
}

// NeXus: "default" leads from group to group, "signal" to the data. Source: manual.nexusformat.org, NXdata.
std::optional<std::string> nexusDefault(const Hdf5Objects& objects) {
  std::string group;
  for (int depth = 0; depth < 8; ++depth) {
    const Hdf5Object* const here = objects.find(group.empty() ? "/" : group);
    if (!here) return std::nullopt;
    if (const auto signal = here->text("signal"))
      return objects.hasDataset(group + "/" + *signal) ? std::optional(group + "/" + *signal) : std::nullopt;
    const std::optional<std::string> next = here->text("default");
    if (!next) return std::nullopt;
    group += "/" + *next;
  }
  return std::nullopt;
}

// Returns the signal of a NeXus group, if only one group has a signal of three axes.
std::optional<std::string> onlySignal(const Hdf5Objects& objects) {
  std::optional<std::string> out;
  for (const std::string& path : objects.volumes()) {
    const std::string group = parentOf(path);
    const Hdf5Object* const above = objects.find(group.empty() ? "/" : group);
    if (!above || above->text("signal") != path.substr(path.find_last_of('/') + 1)) continue;
    if (out) return std::nullopt;
    out = path;
  }
  return out;
}

std::string onlyVolume(const fs::path& file, const Hdf5Objects& objects) {
  const std::vector<std::string> volumes = objects.volumes();
  if (objects.areOthersCut()) throw Error(ErrorCode::kUsage, file, "", kOthersAreCut);
  if (volumes.size() == 1) return volumes.front();
  if (volumes.empty())
    throw Error(ErrorCode::kUnsupported, file, "",
                fmt::format("none of its {} objects is a data set of numbers along three axes", objects.all().size()));
  constexpr std::size_t kMostListed = 24;
  std::string list;
  for (std::size_t i = 0; i < std::min(volumes.size(), kMostListed); ++i) {
    const Hdf5Object& dataset = *objects.find(volumes[i]);
    list += fmt::format("{}{} ({}) {}", i == 0 ? "" : "; ", shown(volumes[i]), fmt::join(dataset.shape, ", "),
                        dataset.type);
  }
  if (volumes.size() > kMostListed) list += fmt::format("; and {} more", volumes.size() - kMostListed);
  throw Error(ErrorCode::kUsage, file, "",
              fmt::format("holds {} data sets: {}; name one, as {}:{}", volumes.size(), list, file.string(),
                          shown(volumes.front())));
}

std::optional<std::string> byConvention(const Hdf5Objects& objects) {
  if (const std::optional<std::string> found = nexusDefault(objects)) return found;
  if (objects.volumes().size() == 1) return std::nullopt;
  // Groups that are not listed may have signals, too.
  if (const std::optional<std::string> found = onlySignal(objects); found && !objects.areOthersCut()) return found;
  return objects.hasDataset("/exchange/data") ? std::optional<std::string>("/exchange/data") : std::nullopt;
}

Hdf5Image ofPath(const Hdf5Objects& objects, const std::string& path) {
  Hdf5Image out;
  out.path = path;
  describeAxes(objects, out);
  return out;
}

}  // namespace

Hdf5Image hdf5ImageAt(const fs::path& file, const std::string& path, const Hdf5Objects& objects, BdvXmlBeside& beside) {
  if (path == kMincImage) return ofMinc(file, objects);
  if (isImarisData(path, objects)) return ofImarisData(file, objects, path);
  if (const std::optional<BdvCells> cells = bdvCellsAt(path, objects)) return ofBdvCells(file, objects, *cells, beside);
  return ofPath(objects, path);
}

Hdf5Image findHdf5Image(const fs::path& file, const std::string& path, const DescribeHdf5& describe,
                        const SourceOptions& options) {
  const Hdf5Objects objects = describe(path);
  if (path.empty() && objects.find("/DataSet/ResolutionLevel 0")) return ofImaris(file, objects, describe, options);
  if (path.empty() && objects.find("/s00/resolutions") && objects.find("/t00000"))
    return ofBigDataViewer(file, objects, describe, options);
  if (options.scale) failOption(file, "--scale", "applies to files of Imaris and BigDataViewer; leave it out");
  if (path.empty() && objects.hasDataset(kMincImage)) return ofMinc(file, objects);
  if (!path.empty()) {
    if (!objects.hasDataset(path))
      throw Error(ErrorCode::kNotFound, file, shown(path),
                  objects.find(path) ? "is no data set of numbers" : "there is no data set of this name");
    BdvXmlBeside beside(file);
    return hdf5ImageAt(file, path, objects, beside);
  }
  if (const std::optional<std::string> found = byConvention(objects)) {
    Hdf5Image out = ofPath(objects, *found);
    if (const std::size_t count = objects.volumes().size(); count > 1)
      out.notes.push_back(fmt::format("took {} of {} data sets; FILE:/PATH names another", shown(*found), count));
    if (objects.areOthersCut()) out.notes.push_back(kOthersAreCut);
    return out;
  }
  return ofPath(objects, onlyVolume(file, objects));
}

}  // namespace kiln
