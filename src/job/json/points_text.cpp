#include "job/json/points_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/error.h"
#include "base/text.h"
#include "image/named_color.h"
#include "job/json/job_json.h"
#include "scene/scene_limits.h"

namespace kiln {
namespace {

struct PointText {
  double value, opacity;
  std::optional<glm::dvec3> color;
};

std::optional<PointText> pointText(std::string_view text) {
  const std::vector<std::string_view> parts = splitAt(text, ':');
  if (parts.size() < 2 || parts.size() > 3) return std::nullopt;
  const auto value = numberOf<double>(parts[0]), opacity = numberOf<double>(parts[1]);
  if (!value || !legal::voxelValue(*value) || !opacity || !legal::fraction(*opacity)) return std::nullopt;
  PointText out{*value, *opacity, std::nullopt};
  if (parts.size() == 3) {
    out.color = colorNamed(parts[2]);
    if (!out.color) return std::nullopt;
  }
  return out;
}

std::vector<PointText> pointTexts(std::string_view text) {
  std::vector<PointText> out;
  for (const std::string_view part : splitAt(text, ',')) {
    const auto point = pointText(part);
    if (!point)
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
  const std::vector<PointText> points = pointTexts(text);
  const auto first = std::find_if(points.begin(), points.end(), [](const PointText& p) { return p.color.has_value(); });
  glm::dvec3 color = first == points.end() ? glm::dvec3(1) : *first->color;
  TransferFunction out;
  for (const PointText& point : points) {
    color = point.color.value_or(color);
    out.points.push_back({point.value, color, point.opacity});
  }
  return out;
}

}  // namespace kiln
