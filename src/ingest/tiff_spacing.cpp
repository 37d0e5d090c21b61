// TIFF has a resolution for printing, and most programs write the printer's or the screen's into it whatever the image
// is. So the tags count only with a unit and a number that no screen or printer has. They do not reach across pages:
// what they say of the pixel is taken for the distance of slices, too, and the user is told.
#include "ingest/tiff_spacing.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "ingest/header_text.h"

namespace kiln {
namespace {

constexpr int kInch = 2, kCentimetre = 3;

bool usable(double spacing) { return std::isfinite(spacing) && spacing > 1e-12 && spacing < 1e12; }

// ImageJ writes the micro sign as \u00B5, and older versions as the byte of Latin-1.
std::string unitNamed(const std::string& text) {
  if (text == "micron" || text == "microns" || text == "um" || text == "\\u00B5m" || text == "\xb5m" ||
      text == "\xc2\xb5m" || text == "\xce\xbcm") {
    return "um";
  }
  if (text == "inch" || text == "inches") return "in";
  for (const char* unit : {"nm", "mm", "cm", "m", "km", "in"}) {
    if (text == unit) return unit;
  }
  return "";
}

// Dots per inch of screens, printers and scanners' menus.
bool isPrinters(double per_inch) {
  constexpr std::array kUsual = {72.0,  75.0,  90.0,  96.0,  100.0, 120.0,  150.0, 200.0,
                                 240.0, 300.0, 360.0, 400.0, 600.0, 1200.0, 2400.0};
  return std::any_of(kUsual.begin(), kUsual.end(), [&](double dpi) { return std::abs(per_inch / dpi - 1) < 0.005; });
}

// unit: mm; zero where the tags do not say.
glm::dvec2 pixelByTags(const TiffPage& page) {
  const double unit_mm = page.resolution_unit == kInch ? 25.4 : page.resolution_unit == kCentimetre ? 10 : 0;
  const glm::dvec2 pixel(unit_mm / page.x_resolution, unit_mm / page.y_resolution);
  if (unit_mm == 0 || !usable(pixel.x) || !usable(pixel.y)) return glm::dvec2(0);
  return isPrinters(25.4 / pixel.x) ? glm::dvec2(0) : pixel;
}

// More than any file has are as good as many.
std::int64_t stacksFrom(std::string_view text) {
  return std::clamp<std::int64_t>(integerOf(text).value_or(1), 1, 1'000'000);
}

std::optional<StackNotes> imageJNotes(std::string_view description) {
  if (!description.starts_with("ImageJ=")) return std::nullopt;
  StackNotes out;
  out.writer = "ImageJ";
  std::string fit, c0, c1;
  while (!description.empty()) {
    const std::string_view line = description.substr(0, description.find('\n'));
    description.remove_prefix(std::min(line.size() + 1, description.size()));
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    const std::string key = trimmed(line.substr(0, equals)), value = trimmed(line.substr(equals + 1));
    if (key == "images") out.images = std::max<std::int64_t>(integerOf(value).value_or(1), 1);
    if (key == "channels") out.channels = stacksFrom(value);
    if (key == "frames") out.frames = stacksFrom(value);
    // Stacks whose order was turned around have a negative one.
    if (key == "spacing") out.spacing = std::abs(doubleOf(value).value_or(0));
    if (key == "unit") {
      out.unit = unitNamed(value);
      out.in_unit = !value.empty() && value != "pixel" && value != "pixels";
    }
    // A calibration, of which 0 is a straight line.
    if (key == "cf") fit = value;
    if (key == "c0") c0 = value;
    if (key == "c1") c1 = value;
  }
  const std::optional<double> at_zero = doubleOf(c0), slope = doubleOf(c1);
  if (fit.empty() || !at_zero || !slope) return out;
  out.offset_signed = fit == "0" && *at_zero == -32768 && *slope == 1;
  if (!out.offset_signed && !(fit == "0" && *at_zero == 0 && *slope == 1))
    out.line = fit == "0" ? fmt::format("{:.9g} + {:.9g} times", *at_zero, *slope) : "a curve (calibration) of";
  return out;
}

// Of an element of XML, <Name a="1" b="2"; empty where it has none of that name.
std::string attributeOf(std::string_view element, const std::string& name) {
  const std::size_t at = element.find(" " + name + "=");
  if (at == std::string_view::npos || at + name.size() + 2 >= element.size()) return "";
  const std::size_t first = at + name.size() + 2;  // the quote
  const std::size_t last = element.find(element[first], first + 1);
  return last == std::string_view::npos ? "" : std::string(element.substr(first + 1, last - first - 1));
}

// Source: the OME data model of 2016-06, Pixels.
std::optional<StackNotes> omeNotes(std::string_view description) {
  if (description.find("<OME ") == std::string_view::npos) return std::nullopt;
  description.remove_prefix(std::min(description.find("<Pixels "), description.size()));
  const std::string_view pixels = description.substr(0, description.find('>'));
  const auto of = [&](const std::string& name) { return attributeOf(pixels, name); };
  StackNotes out;
  out.writer = "OME";
  out.channels = stacksFrom(of("SizeC"));
  out.frames = stacksFrom(of("SizeT"));
  // Micrometres if nothing is said; what is along other axes counts where it has the same unit.
  const auto unit = [&](const std::string& name) {
    return of(name + "Unit").empty() ? "um" : unitNamed(of(name + "Unit"));
  };
  out.unit = unit("PhysicalSizeX");
  const auto length = [&](const std::string& name) {
    return unit(name) == out.unit ? doubleOf(of(name)).value_or(0) : 0;
  };
  out.pixel = {length("PhysicalSizeX"), length("PhysicalSizeY")};
  out.spacing = length("PhysicalSizeZ");
  return out;
}

// {"shape": [2, 5, 64, 64]}: beyond three dimensions that are no 1, they are channels, times or positions.
std::optional<StackNotes> tifffileNotes(std::string_view description) {
  constexpr std::string_view kBegin = "{\"shape\": [";
  if (!description.starts_with(kBegin)) return std::nullopt;
  description.remove_prefix(kBegin.size());
  const std::string shape(description.substr(0, description.find(']')));
  std::vector<std::int64_t> dims;
  for (std::size_t at = 0; at < shape.size();) {
    const std::size_t end = std::min(shape.find(',', at), shape.size());
    if (const auto dim = integerOf(trimmed(std::string_view(shape).substr(at, end - at))); dim && *dim != 1)
      dims.push_back(*dim);
    at = end + 1;
  }
  StackNotes out;
  out.writer = "tifffile";
  for (std::size_t i = 0; i + 3 < dims.size(); ++i)
    out.channels = std::min<std::int64_t>(out.channels * std::clamp<std::int64_t>(dims[i], 1, 1000), 1'000'000);
  return out;
}

}  // namespace

std::optional<StackNotes> stackNotes(std::string_view description) {
  for (const auto& read : {imageJNotes, omeNotes, tifffileNotes}) {
    if (std::optional<StackNotes> out = read(description)) return out;
  }
  return std::nullopt;
}

VolumeGeometry tiffGeometry(const Extent3& dims, const TiffPage& page, const std::optional<StackNotes>& stack,
                            const SourceOptions& options, std::vector<std::string>& notes) {
  VolumeGeometry out;
  out.dims = dims;
  glm::dvec3 spacing(1);
  const glm::dvec2 tags = pixelByTags(page);
  const bool told = stack && usable(stack->pixel.x) && usable(stack->pixel.y);
  if (stack && (usable(stack->spacing) || stack->in_unit || told)) {
    const glm::dvec2 pixel = told ? stack->pixel : glm::dvec2(1 / page.x_resolution, 1 / page.y_resolution);
    const bool sized = told || (stack->in_unit && usable(pixel.x) && usable(pixel.y));
    if (sized) spacing = glm::dvec3(pixel, pixel.x);
    if (usable(stack->spacing)) spacing.z = stack->spacing;
    if (sized) out.unit = stack->unit;
  } else if (tags.x > 0) {
    spacing = glm::dvec3(tags, tags.x);
    out.unit = "mm";
    if (!options.spacing && dims.z > 1) {
      notes.push_back(
          fmt::format("the TIFF files say {:.6g} mm a pixel and nothing of the distance of slices, which is taken "
                      "to be the same; --spacing says otherwise",
                      tags.x));
    }
  }
  if (options.spacing) spacing = *options.spacing;
  out.world_from_index = axesAffine(spacing, glm::dvec3(0));
  return out;
}

}  // namespace kiln
