#include "scene/transfer/value_text.h"

#include <cmath>
#include <vector>

#include "base/text.h"
#include "image/named_color.h"
#include "scene/scene_limits.h"

namespace kiln {

std::optional<ValueText> valueText(std::string_view text) {
  const std::vector<std::string_view> parts = splitAt(text, ':');
  const std::optional<double> value = numberOf<double>(parts[0]);
  if (parts.size() > 3 || !value || !(std::abs(*value) <= kLargestValue)) return std::nullopt;
  ValueText out{*value, std::nullopt, std::nullopt};
  if (parts.size() > 1) {
    out.opacity = numberOf<double>(parts[1]);
    if (!out.opacity || !(*out.opacity >= 0 && *out.opacity <= 1)) return std::nullopt;
  }
  if (parts.size() > 2) {
    out.color = colorNamed(parts[2]);
    if (!out.color) return std::nullopt;
  }
  return out;
}

}  // namespace kiln
