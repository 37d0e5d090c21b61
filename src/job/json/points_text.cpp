#include "job/json/points_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/error.h"
#include "base/text.h"
#include "image/named_color.h"
#include "scene/scene_limits.h"
#include "scene/transfer/value_text.h"

namespace kiln {
namespace {

std::vector<ValueText> pointTexts(std::string_view text) {
  std::vector<ValueText> out;
  for (const std::string_view part : splitAt(text, ',')) {
    const auto point = valueText(part);
    if (!point || !point->opacity)
      throw Error(
          ErrorCode::kUsage,
          fmt::format("expected points VALUE:OPACITY[:COLOR] separated by commas, OPACITY from 0 to 1, COLOR {}, "
                      "found '{}'",
                      kColorForms, part));
    if (!out.empty() && point->value < out.back().value)
      throw Error(ErrorCode::kUsage, fmt::format("expected points in order of their values, found {} after {}",
                                                 point->value, out.back().value));
    out.push_back(*point);
  }
  if (out.size() > kMostPoints)
    throw Error(ErrorCode::kUsage, fmt::format("expected at most {} points, found {}", kMostPoints, out.size()));
  return out;
}

}  // namespace

bool isPointsText(std::string_view text) {
  const std::size_t colon = text.find(':');
  return colon != std::string_view::npos && decimalOf<double>(text.substr(0, colon));
}

TransferFunction functionOfPoints(std::string_view text) {
  const std::vector<ValueText> points = pointTexts(text);
  const auto first = std::find_if(points.begin(), points.end(), [](const ValueText& p) { return p.color.has_value(); });
  glm::dvec3 color = first == points.end() ? glm::dvec3(1) : *first->color;
  TransferFunction out;
  for (const ValueText& point : points) {
    color = point.color.value_or(color);
    out.points.push_back({point.value, color, *point.opacity});
  }
  return out;
}

}  // namespace kiln
