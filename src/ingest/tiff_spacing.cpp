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

}  // namespace

std::optional<ImageJNotes> imageJNotes(std::string_view description) {
  if (!description.starts_with("ImageJ=")) return std::nullopt;
  ImageJNotes out;
  while (!description.empty()) {
    const std::string_view line = description.substr(0, description.find('\n'));
    description.remove_prefix(std::min(line.size() + 1, description.size()));
    const std::size_t equals = line.find('=');
    if (equals == std::string_view::npos) continue;
    const std::string key = trimmed(line.substr(0, equals)), value = trimmed(line.substr(equals + 1));
    if (key == "images") out.images = std::max<std::int64_t>(integerOf(value).value_or(1), 1);
    if (key == "channels") out.channels = std::max<std::int64_t>(integerOf(value).value_or(1), 1);
    if (key == "frames") out.frames = std::max<std::int64_t>(integerOf(value).value_or(1), 1);
    // Stacks whose order was turned around have a negative one.
    if (key == "spacing") out.spacing = std::abs(doubleOf(value).value_or(0));
    if (key == "unit") out.unit = unitNamed(value);
  }
  return out;
}

VolumeGeometry tiffGeometry(const Extent3& dims, const TiffPage& page, const std::optional<ImageJNotes>& imagej,
                            const SourceOptions& options, std::vector<std::string>& notes) {
  VolumeGeometry out;
  out.dims = dims;
  glm::dvec3 spacing(1);
  const glm::dvec2 tags = pixelByTags(page);
  if (imagej && (usable(imagej->spacing) || !imagej->unit.empty())) {
    // ImageJ's resolution is in pixels per its own unit.
    const glm::dvec2 pixel(1 / page.x_resolution, 1 / page.y_resolution);
    const bool sized = !imagej->unit.empty() && usable(pixel.x) && usable(pixel.y);
    if (sized) spacing = glm::dvec3(pixel, pixel.x);
    if (usable(imagej->spacing)) spacing.z = imagej->spacing;
    if (sized) out.unit = imagej->unit;
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
