#include "frame/slice_palette.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"
#include "image/srgb.h"
#include "scene/transfer/display_map.h"

namespace kiln {

SlicePalette::SlicePalette(const std::string& map, const Window& window) : window_(window) {
  if (!(window.width > 0) || !std::isfinite(window.centre))
    throw Error(ErrorCode::kUsage, "--window: the width must be positive");
  const std::vector<std::string> maps = displayMapNames();
  if (std::find(maps.begin(), maps.end(), map) == maps.end())
    throw Error(ErrorCode::kUsage, fmt::format("--colormap: expected {} (found '{}')", fmt::join(maps, ", "), map));
  const ColorMap colors = displayMap(map);
  for (std::size_t i = 0; i < kSteps; ++i) {
    const glm::dvec3 srgb = colors.at(static_cast<double>(i) / (kSteps - 1));
    for (int channel = 0; channel < 3; ++channel)
      colors_[i][channel] = static_cast<float>(linearFromSrgb(srgb[channel]));
  }
}

const glm::vec3* SlicePalette::of(double value) const {
  if (std::isnan(value)) return nullptr;
  const double part = std::clamp((value - window_.centre) / window_.width + 0.5, 0.0, 1.0);
  return &colors_[static_cast<std::size_t>(part * (kSteps - 1) + 0.5)];
}

SliceColors::SliceColors(const std::vector<LabelStyle>& labels, const std::string& map, const Window& window) {
  for (const LabelStyle& style : labels) {
    labels_.push_back(style.label);
    if (style.opacity > 0)
      colors_.emplace_back(glm::vec3(style.color));
    else
      colors_.emplace_back();
  }
  if (labels_.empty()) palette_.emplace(map, window);
}

const glm::vec3* SliceColors::of(double value) const {
  if (palette_) return palette_->of(value);
  const auto found = std::lower_bound(labels_.begin(), labels_.end(), value);
  if (found == labels_.end() || *found != value) return nullptr;
  const std::optional<glm::vec3>& color = colors_[static_cast<std::size_t>(found - labels_.begin())];
  return color ? &*color : nullptr;
}

}  // namespace kiln
