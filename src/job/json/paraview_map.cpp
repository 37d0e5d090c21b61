#include "job/json/paraview_map.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "scene/scene_limits.h"

namespace kiln {
namespace {

// Names of spaces; the last two are older spellings.
constexpr std::array<std::string_view, 7> kSpaceNames = {"RGB", "HSV", "Wrapped", "Lab", "Step", "CIELAB", "Diverging"};
constexpr std::array<ColorSpace, 7> kSpaces = {ColorSpace::kRgb,      ColorSpace::kHsv,  ColorSpace::kHsvWrapped,
                                               ColorSpace::kLab,      ColorSpace::kStep, ColorSpace::kLab,
                                               ColorSpace::kDiverging};

bool flagOf(const JobObject& object, std::string_view key) {
  // ParaView writes true or 1.
  return object.has(key) && (object.isNumber(key) ? object.integer(key, 0, 1) == 1 : *object.flag(key));
}

template <class Node>
void sortByValue(std::vector<Node>& nodes) {
  std::stable_sort(nodes.begin(), nodes.end(), [](const Node& a, const Node& b) { return a.value < b.value; });
}

// Groups of four numbers: a value, then three from 0 to 1.
std::vector<double> quadruples(const JobObject& object, std::string_view key, std::string_view expected) {
  const std::vector<double> numbers = *object.numberList(key, expected, legal::voxelValue);
  if (numbers.empty() || numbers.size() % 4 != 0) object.refuse(key, expected);
  if (numbers.size() / 4 > kMostPoints)
    object.complain(key, fmt::format("expected at most {} points, found {}", kMostPoints, numbers.size() / 4));
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i % 4 != 0 && !legal::fraction(numbers[i])) object.refuse(key, expected);
  }
  return numbers;
}

}  // namespace

bool ParaViewMap::normalised() const { return colors.nodes.front().value == 0 && colors.nodes.back().value == 1; }

bool isParaViewMap(const JobObject& object) { return object.has("RGBPoints") || object.has("IndexedColors"); }

ParaViewMap paraViewMapFrom(const JobObject& object) {
  for (const char* scale : {"UseLogScale", "UseLogScaleForOpacity"}) {
    if (flagOf(object, scale))
      throw Error(ErrorCode::kUnsupported, object.path(), object.placeOf(scale),
                  "a colour map with a logarithmic scale is not drawn; export it with a linear one");
  }
  if (!object.has("RGBPoints"))
    object.complain("RGBPoints", "is missing; a map of categories (IndexedColors) has no colours between values");
  ParaViewMap out;
  const auto space = object.choice("ColorSpace", kSpaceNames);
  out.colors.space = space ? kSpaces[*space] : ColorSpace::kRgb;
  if (out.colors.space == ColorSpace::kHsv && flagOf(object, "HSVWrap")) out.colors.space = ColorSpace::kHsvWrapped;
  const std::vector<double> colors =
      quadruples(object, "RGBPoints", "[value, red, green, blue, …], colours from 0 to 1");
  for (std::size_t i = 0; i < colors.size(); i += 4)
    out.colors.nodes.push_back({colors[i], {colors[i + 1], colors[i + 2], colors[i + 3]}});
  sortByValue(out.colors.nodes);
  if (object.has("Points")) {
    const std::vector<double> points = quadruples(
        object, "Points", "[value, opacity, midpoint, sharpness, …], opacity, midpoint and sharpness from 0 to 1");
    out.opacity.emplace();
    for (std::size_t i = 0; i < points.size(); i += 4)
      out.opacity->nodes.push_back({points[i], points[i + 1], points[i + 2], points[i + 3]});
    sortByValue(out.opacity->nodes);
  }
  return out;
}

}  // namespace kiln
