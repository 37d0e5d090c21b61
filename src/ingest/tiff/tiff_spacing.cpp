// Problem. Most programs write the resolution of a printer or screen into TIFF's tags, whatever the image is.
// Method. The tags count only with a unit and a number that no screen or printer has. They give no distance of slices:
// the pixel size is used, and a note reports the assumption.
// Descriptions by ImageJ, OME and tifffile take precedence over a log of SkyScan, and the log over the tags.
#include "ingest/tiff/tiff_spacing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "grid/length_unit.h"
#include "ingest/source/header_text.h"
#include "ingest/source/json_node.h"

namespace kiln {
namespace {

constexpr int kNoUnit = 1, kInch = 2, kCentimetre = 3;

bool usable(double spacing) { return std::isfinite(spacing) && spacing > 1e-12 && spacing < 1e12; }

std::string unknownUnit(const char* writer, std::string_view unit) {
  return fmt::format("{}'s description gives lengths in {}, which is no known unit; they are taken without a unit",
                     writer, inQuotes(unit));
}

std::string unlikeUnit(const char* writer, char axis, std::string_view unit, std::string_view of_x) {
  return fmt::format(
      "{}'s description gives the length along {} in {} and along x in {}, of which one is unknown; the "
      "length along {} is not used; set --spacing",
      writer, axis, inQuotes(unit), inQuotes(of_x), axis);
}

// True for dots per inch of common screens, printers and scanners.
bool isPrinters(double per_inch) {
  constexpr std::array kUsual = {72.0,  75.0,  90.0,  96.0,  100.0, 120.0,  150.0, 200.0,
                                 240.0, 300.0, 360.0, 400.0, 600.0, 1200.0, 2400.0};
  return std::any_of(kUsual.begin(), kUsual.end(), [&](double dpi) { return std::abs(per_inch / dpi - 1) < 0.005; });
}

// unit: mm; zero if the tags give no usable size.
glm::dvec2 pixelByTags(const TiffPage& page) {
  const double unit_mm = page.resolution_unit == kInch ? 25.4 : page.resolution_unit == kCentimetre ? 10 : 0;
  const glm::dvec2 pixel(unit_mm / page.x_resolution, unit_mm / page.y_resolution);
  if (unit_mm == 0 || !usable(pixel.x) || !usable(pixel.y)) return glm::dvec2(0);
  return isPrinters(25.4 / pixel.x) ? glm::dvec2(0) : pixel;
}

constexpr std::int64_t kMostStacks = 1'000'000, kMostImages = 1'000'000'000;

// Clamps: larger numbers than any file has are treated as a million.
std::int64_t stacksFrom(std::string_view text) {
  return std::clamp<std::int64_t>(integerOf(text).value_or(1), 1, kMostStacks);
}

// ImageJ omits the distance of slices if it is exactly 1. y and z may have units of their own.
void useUnits(StackNotes& out, const std::string& x, const std::string& y, const std::string& z) {
  out.unit = unitName(x);
  if (out.unit.empty()) out.remarks.push_back(unknownUnit(out.writer, x));
  if (out.spacing == 0 && out.images > 1) out.spacing = 1;
  const std::optional<LengthRatio> from_y = lengthRatio(y, x), from_z = lengthRatio(z, x);
  if (from_y) out.y_scale = from_y->of(1);
  if (!from_y) out.remarks.push_back(unlikeUnit(out.writer, 'y', y, x));
  if (!from_z) out.remarks.push_back(unlikeUnit(out.writer, 'z', z, x));
  out.spacing = from_z ? from_z->of(out.spacing) : 0;
}

std::optional<StackNotes> imageJNotes(std::string_view description) {
  if (!description.starts_with("ImageJ=")) return std::nullopt;
  StackNotes out;
  out.writer = "ImageJ";
  std::string fit, c0, c1, unit, unit_y, unit_z;
  while (!description.empty()) {
    const std::string_view line = description.substr(0, description.find('\n'));
    description.remove_prefix(std::min(line.size() + 1, description.size()));
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    const std::string key = trimmed(line.substr(0, equals)), value = trimmed(line.substr(equals + 1));
    if (key == "images") out.images = std::clamp<std::int64_t>(integerOf(value).value_or(1), 1, kMostImages);
    if (key == "channels") out.channels = stacksFrom(value);
    if (key == "frames") out.frames = stacksFrom(value);
    if (key == "slices") out.slices = stacksFrom(value);
    // Stacks in reversed order have a negative distance.
    if (key == "spacing") out.spacing = std::abs(doubleOf(value).value_or(0));
    // Exact lengths by kiln export; the resolution tags have 32 bits.
    if (key == "pixel_width") out.pixel.x = doubleOf(value).value_or(0);
    if (key == "pixel_height") out.pixel.y = doubleOf(value).value_or(0);
    if (key == "unit") unit = value;
    if (key == "yunit") unit_y = value;
    if (key == "zunit") unit_z = value;
    // A calibration function; 0 is a straight line.
    if (key == "cf") fit = value;
    if (key == "c0") c0 = value;
    if (key == "c1") c1 = value;
  }
  // Channels follow each other fastest, then slices, then frames.
  if (out.slices == 0) out.slices = std::max<std::int64_t>(out.images / (out.channels * out.frames), 1);
  out.slice_step = out.channels;
  out.frame_step = out.channels * out.slices;
  out.in_unit = !unit.empty() && unit != "pixel" && unit != "pixels";
  if (out.in_unit) useUnits(out, unit, unit_y.empty() ? unit : unit_y, unit_z.empty() ? unit : unit_z);
  const std::optional<double> at_zero = doubleOf(c0), slope = doubleOf(c1);
  if (fit.empty() || !at_zero || !slope) return out;
  out.offset_signed = fit == "0" && *at_zero == -32768 && *slope == 1;
  if (!out.offset_signed && !(fit == "0" && *at_zero == 0 && *slope == 1))
    out.line = fit == "0" ? fmt::format("{:.9g} + {:.9g} times", *at_zero, *slope) : "a curve (calibration) of";
  return out;
}

// Returns an attribute of an XML element, <Name a="1" b="2"; empty if the element lacks it.
std::string attributeOf(std::string_view element, const std::string& name) {
  const std::size_t at = element.find(" " + name + "=");
  if (at == std::string_view::npos || at + name.size() + 2 >= element.size()) return "";
  const std::size_t first = at + name.size() + 2;  // the quote
  const std::size_t last = element.find(element[first], first + 1);
  return last == std::string_view::npos ? "" : std::string(element.substr(first + 1, last - first - 1));
}

// Sets the steps by an order of axes, fastest first: "XYCZT". Steps of an axis that is repeated would lead beyond the
// last image.
void useOrder(StackNotes& out, std::string_view order) {
  constexpr std::string_view kStepped = "ZCT";
  std::string left(kStepped);
  std::int64_t step = 1;
  for (const char axis : order) {
    if (kStepped.find(axis) == std::string_view::npos) continue;
    if (std::erase(left, axis) == 0) {
      if (out.disorder.empty()) out.disorder = fmt::format("{}'s description repeats an axis in its order", out.writer);
      return;
    }
    if (axis == 'Z') out.slice_step = std::exchange(step, step * out.slices);
    if (axis == 'C') out.channel_step = std::exchange(step, step * out.channels);
    if (axis == 'T') out.frame_step = std::exchange(step, step * out.frames);
  }
}

// Calls `use` with each element of this name up to the first end of a Pixels element.
template <class Use>
void forEachElement(std::string_view pixels, const std::string& name, Use&& use) {
  pixels = pixels.substr(0, pixels.find("</Pixels>"));
  const std::string begin = "<" + name + " ";
  for (std::size_t at = 0; (at = pixels.find(begin, at)) != std::string_view::npos;) {
    const std::size_t end = std::min(pixels.find('>', at), pixels.size());
    use(pixels.substr(at, end - at));
    at = end;
  }
}

// A TiffData element places planes. Kiln reads planes that follow the order of dimensions; of planes in several files
// the names of the files decide.
void usePlaces(StackNotes& out, std::string_view pixels) {
  if (pixels.find("FileName=") != std::string_view::npos) return;
  forEachElement(pixels, "TiffData", [&](std::string_view element) {
    const auto of = [&](const char* name) { return integerOf(attributeOf(element, name)).value_or(0); };
    if (attributeOf(element, "IFD").empty()) return;
    const double expected = static_cast<double>(of("FirstZ")) * static_cast<double>(out.slice_step) +
                            static_cast<double>(of("FirstC")) * static_cast<double>(out.channel_step) +
                            static_cast<double>(of("FirstT")) * static_cast<double>(out.frame_step);
    if (static_cast<double>(of("IFD")) != expected)
      out.disorder = "OME's description puts the planes into an order of their own, not the order of dimensions";
  });
}

// Source: the OME data model of 2016-06, Pixels.
std::optional<StackNotes> omeNotes(std::string_view description) {
  if (description.find("<OME ") == std::string_view::npos) return std::nullopt;
  description.remove_prefix(std::min(description.find("<Pixels "), description.size()));
  const std::string_view within = description;
  const std::string_view pixels = description.substr(0, description.find('>'));
  const auto of = [&](const std::string& name) { return attributeOf(pixels, name); };
  StackNotes out;
  out.writer = "OME";
  out.channels = stacksFrom(of("SizeC"));
  out.frames = stacksFrom(of("SizeT"));
  out.images = stacksFrom(of("SizeZ"));
  out.slices = out.images;
  useOrder(out, of("DimensionOrder"));
  if (out.channels > 1 || out.frames > 1) usePlaces(out, within);
  forEachElement(within, "Channel",
                 [&](std::string_view element) { out.channel_names.push_back(attributeOf(element, "Name")); });
  out.counts_all_files = true;
  // Micrometres are OME's default for each axis.
  const auto unit = [&](const std::string& axis) {
    const std::string text = of("PhysicalSize" + axis + "Unit");
    return text.empty() ? std::string("um") : text;
  };
  const std::string of_x = unit("X");
  if (doubleOf(of("PhysicalSizeX"))) {
    out.unit = unitName(of_x);
    if (out.unit.empty()) out.remarks.push_back(unknownUnit(out.writer, of_x));
  }
  const auto length = [&](const std::string& axis) {
    const double number = doubleOf(of("PhysicalSize" + axis)).value_or(0);
    const std::optional<LengthRatio> ratio = lengthRatio(unit(axis), of_x);
    if (!ratio && number != 0) out.remarks.push_back(unlikeUnit(out.writer, axis == "Y" ? 'y' : 'z', unit(axis), of_x));
    return ratio ? ratio->of(number) : 0;
  };
  out.pixel = {length("X"), length("Y")};
  if (out.pixel.y == 0) out.pixel.y = out.pixel.x;
  out.spacing = length("Z");
  return out;
}

// Users of tifffile give "spacing": 2.0, "unit": "um" the meaning that both have in ImageJ; three spacings are of z, y
// and x.
void useTifffileLengths(StackNotes& out, const JsonNode& description) {
  if (const std::optional<JsonNode> spacing = description.find("spacing")) {
    const std::vector<double> spacings = spacing->isList() ? spacing->numbers() : std::vector{spacing->number()};
    if (!spacings.empty()) out.spacing = std::abs(spacings.front());
    if (spacings.size() == 3) out.pixel = {std::abs(spacings[2]), std::abs(spacings[1])};
  }
  const std::optional<JsonNode> named = description.find("unit");
  const std::string unit = named ? named->text() : "";
  if (unit.empty() || unit.starts_with("pixel")) return;
  out.in_unit = out.tags_may_have_units = true;
  out.unit = unitName(unit);
  if (out.unit.empty()) out.remarks.push_back(unknownUnit(out.writer, unit));
}

// {"shape": [2, 5, 64, 64], "axes": "CZYX"}. Without axes all dimensions beyond the last three are channels.
StackNotes notesOfTifffile(const JsonNode& description, int samples) {
  std::vector<std::int64_t> dims = description.at("shape").wholes();
  for (std::int64_t& dim : dims) dim = std::clamp<std::int64_t>(dim, 1, kMostStacks);
  const std::optional<JsonNode> named = description.find("axes");
  std::string axes = named ? named->text() : "";
  // The samples of a colour are the last dimension, and no axis of the volume.
  if (samples > 1 && !dims.empty() && dims.back() == samples) {
    if (axes.size() == dims.size()) axes.pop_back();
    dims.pop_back();
  }
  if (axes.size() != dims.size()) {
    std::erase(dims, 1);
    axes = std::string(dims.size() > 3 ? dims.size() - 3 : 0, 'C') + "ZYX";
    axes.erase(0, axes.size() - std::min(axes.size(), dims.size()));
  }
  StackNotes out;
  out.writer = "tifffile";
  out.slices = 1;
  std::string order;
  for (std::size_t i = axes.size(); i-- > 0;) {
    std::int64_t& count = axes[i] == 'Z' ? out.slices : axes[i] == 'T' ? out.frames : out.channels;
    if (axes[i] == 'Y' || axes[i] == 'X') continue;
    count = std::min<std::int64_t>(count * dims[i], kMostStacks);
    const char kind = axes[i] == 'Z' || axes[i] == 'T' ? axes[i] : 'C';
    if (dims[i] == 1 || order.ends_with(kind)) continue;
    if (order.find(kind) != std::string::npos)
      out.disorder = "tifffile's axes " + inQuotes(axes) + " are no channels, slices and times";
    order += kind;
  }
  useOrder(out, order);
  // The images then follow the only directory, as ImageJ's do.
  if (const std::optional<JsonNode> truncated = description.find("truncated"); truncated && truncated->truth())
    out.images = std::min(out.slices * out.channels * out.frames, kMostImages);
  useTifffileLengths(out, description);
  return out;
}

// Reads a JSON object with a list "shape" as tifffile's. Metadata of its user may stand in front of the list. Returns
// nothing for other texts.
std::optional<StackNotes> tifffileNotes(std::string_view description, int samples) {
  if (!description.starts_with('{')) return std::nullopt;
  try {
    return notesOfTifffile(JsonNode({}, std::string(description), UINT64_MAX), samples);
  } catch (const Error&) {
    return std::nullopt;
  }
}

// The edges of a pixel by the tags, in the unit of the description; 0 if the tags have no usable size.
glm::dvec2 pixelInUnit(const TiffPage& page, const StackNotes& stack) {
  if (stack.tags_may_have_units && page.resolution_unit != kNoUnit) {
    const std::optional<LengthRatio> from_mm = lengthRatio("mm", stack.unit);
    const glm::dvec2 tags = pixelByTags(page);
    return from_mm ? glm::dvec2(from_mm->of(tags.x), from_mm->of(tags.y)) : glm::dvec2(0);
  }
  return glm::dvec2(1 / page.x_resolution, stack.y_scale / page.y_resolution);
}

}  // namespace

std::optional<StackNotes> stackNotes(std::string_view description, int samples) {
  for (const auto& read : {imageJNotes, omeNotes}) {
    if (std::optional<StackNotes> out = read(description)) return out;
  }
  return tifffileNotes(description, samples);
}

VolumeGeometry tiffGeometry(const Extent3& dims, const TiffPage& page, const std::optional<StackNotes>& stack,
                            const std::optional<LoggedSpacing>& log, const SourceOptions& options,
                            std::vector<std::string>& notes) {
  VolumeGeometry out;
  out.dims = dims;
  glm::dvec3 spacing(1);
  const glm::dvec2 tags = pixelByTags(page);
  const bool told = stack && usable(stack->pixel.x) && usable(stack->pixel.y);
  std::string choice;
  const auto sameDistance = [&](const std::string& who) {
    if (dims.z > 1)
      choice = fmt::format(
          "{} {:.6g}{} a pixel and no distance of slices, which is taken to be equal; "
          "--spacing sets another",
          who, spacing.x, out.unit.empty() ? "" : " " + out.unit);
  };
  if (stack && (usable(stack->spacing) || stack->in_unit || told)) {
    const glm::dvec2 pixel = told ? stack->pixel : pixelInUnit(page, *stack);
    const bool sized = told || (stack->in_unit && usable(pixel.x) && usable(pixel.y));
    if (sized) spacing = glm::dvec3(pixel, pixel.x);
    if (sized) out.unit = stack->unit;
    if (usable(stack->spacing))
      spacing.z = stack->spacing;
    else
      sameDistance(fmt::format("{}'s description has", stack->writer));
  } else if (log) {
    spacing = log->spacing_um;
    out.unit = "um";
    choice = fmt::format("the size of a voxel, {:.6g} x {:.6g} x {:.6g} um, is by the log {}", spacing.x, spacing.y,
                         spacing.z, inQuotes(log->log.filename().string()));
  } else if (tags.x > 0) {
    spacing = glm::dvec3(tags, tags.x);
    out.unit = "mm";
    sameDistance("the TIFF files have");
  } else {
    choice = "the TIFF files have no size of a voxel, which is taken to be 1 x 1 x 1; --spacing sets another";
  }
  if (options.spacing) {
    spacing = *options.spacing;
  } else {
    if (stack) notes.insert(notes.end(), stack->remarks.begin(), stack->remarks.end());
    if (!choice.empty()) notes.push_back(choice);
  }
  out.world_from_index = axesAffine(spacing, glm::dvec3(0));
  return out;
}

}  // namespace kiln
