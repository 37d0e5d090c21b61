#include "scene/transfer/display_map.h"

#include "base/error.h"
#include "base/number_text.h"
#include "scene/transfer/named_color_maps.h"

namespace kiln {
namespace {

constexpr std::string_view kGray = "gray";

// Returns the value below which the share `part` of all voxels lies.
double quantile(const ValueHistogram& histogram, double part) {
  double total = 0;
  for (const std::uint64_t count : histogram.counts) total += static_cast<double>(count);
  double below = 0;
  for (std::size_t bin = 0; bin < histogram.counts.size(); ++bin) {
    below += static_cast<double>(histogram.counts[bin]);
    if (below >= part * total) {
      return histogram.lo + (histogram.hi - histogram.lo) * (static_cast<double>(bin) + 0.5) /
                                static_cast<double>(histogram.counts.size());
    }
  }
  return histogram.hi;
}

}  // namespace

std::vector<std::string> displayMapNames() {
  std::vector<std::string> out = {std::string(kGray)};
  out.insert(out.end(), colorMapNames().begin(), colorMapNames().end());
  return out;
}

ColorMap displayMap(std::string_view name) {
  return name == kGray ? ColorMap{ColorSpace::kRgb, {{0, glm::dvec3(0)}, {1, glm::dvec3(1)}}} : namedColorMap(name);
}

Window defaultWindow(const ValueHistogram& histogram) {
  const double lo = quantile(histogram, 0.005);
  const double hi = quantile(histogram, 0.995);
  return {(lo + hi) / 2, hi > lo ? hi - lo : 1};
}

std::string windowText(const Window& window) {
  constexpr double kSteps = 1000;  // as a picture shows no finer ones
  return numberText(window.centre, window.width / kSteps) + "," + numberText(window.width, window.width / kSteps);
}

TransferFunction functionOf(const Section& section) {
  const double centre = section.window->x, width = section.window->y;
  const ValueRange values{centre - 0.5 * width, centre + 0.5 * width};
  ColorMap colors = displayMap(section.color_map);
  stretch(colors, {0, 1}, values);
  TransferFunction out;
  out.points = sampled(colors, OpacityCurve{{{values.lo, 1}, {values.hi, 1}}});
  return out;
}

Section resolved(Section section, const Manifest& manifest, const TransferFunction& function) {
  if (section.color_map.empty()) {
    if (!function.surfaces.empty())
      throw Error(ErrorCode::kUsage,
                  "--section: surfaces (iso:VALUE) colour no values; give a window or a colour map, or choose "
                  "solid:VALUE");
    return section;
  }
  if (manifest.volume_class == VolumeClass::kLabels)
    throw Error(ErrorCode::kUsage,
                "--section: labels have no window and no colour map, but colours of their own; write --section tf");
  if (!section.window) {
    const Window window = defaultWindow(manifest.histogram);
    section.window = {window.centre, window.width};
  }
  return section;
}

}  // namespace kiln
