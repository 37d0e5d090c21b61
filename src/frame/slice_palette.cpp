#include "frame/slice_palette.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "base/error.h"
#include "image/srgb.h"
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

std::vector<std::string> sliceColorMaps() {
  std::vector<std::string> out = {std::string(kGray)};
  out.insert(out.end(), colorMapNames().begin(), colorMapNames().end());
  return out;
}

Window defaultWindow(const ValueHistogram& histogram) {
  const double lo = quantile(histogram, 0.005);
  const double hi = quantile(histogram, 0.995);
  return {(lo + hi) / 2, hi > lo ? hi - lo : 1};
}

SlicePalette::SlicePalette(const std::string& map, const Window& window) : window_(window) {
  if (!(window.width > 0) || !std::isfinite(window.centre))
    throw Error(ErrorCode::kUsage, "--window: the width must be positive");
  const std::vector<std::string> maps = sliceColorMaps();
  if (std::find(maps.begin(), maps.end(), map) == maps.end())
    throw Error(ErrorCode::kUsage, fmt::format("--colormap: expected {} (found '{}')", fmt::join(maps, ", "), map));
  const ColorMap colors =
      map == kGray ? ColorMap{ColorSpace::kRgb, {{0, glm::dvec3(0)}, {1, glm::dvec3(1)}}} : namedColorMap(map);
  for (std::size_t i = 0; i < kSteps; ++i) {
    const glm::dvec3 srgb = colors.at(static_cast<double>(i) / (kSteps - 1));
    for (int channel = 0; channel < 3; ++channel)
      colors_[i][channel] = static_cast<float>(linearFromSrgb(srgb[channel]));
  }
}

const glm::vec3& SlicePalette::of(double value) const {
  const double part = std::clamp((value - window_.centre) / window_.width + 0.5, 0.0, 1.0);
  return colors_[static_cast<std::size_t>(part * (kSteps - 1) + 0.5)];
}

}  // namespace kiln
