// N5 itself has no sizes; each family of programs has its own attributes. Source: README of
// github.com/saalfeldlab/n5-viewer (pixelResolution, scales, downsamplingFactors); neuroglancer's N5 data source (axes,
// units, resolution); "transform" in n5-universe's CosemToImagePlus and the data sets of OpenOrganelle.
#include "ingest/zarr/n5_place.h"

#include <algorithm>
#include <string>

namespace kiln {
namespace {

// Lists of N5 begin with x, the fastest axis.
template <class T>
std::optional<std::vector<T>> ofLength(std::vector<T> list, std::size_t axes) {
  if (list.size() != axes) return std::nullopt;
  std::reverse(list.begin(), list.end());
  return list;
}

std::optional<std::vector<double>> numbersIn(const std::optional<JsonNode>& list, std::size_t axes) {
  return list && list->isList() ? ofLength(list->numbers(), axes) : std::nullopt;
}

// A list of numbers at `key`, or at `key`.dimensions.
std::optional<std::vector<double>> lengthsAt(const std::optional<JsonNode>& attributes, const char* key,
                                             std::size_t axes) {
  const std::optional<JsonNode> found = attributes ? attributes->find(key) : std::nullopt;
  return numbersIn(found && found->isObject() ? found->find("dimensions") : found, axes);
}

std::optional<std::vector<std::string>> textsAt(const std::optional<JsonNode>& attributes, const char* key,
                                                std::size_t axes) {
  const std::optional<JsonNode> found = attributes ? attributes->find(key) : std::nullopt;
  if (!found || !found->isList()) return std::nullopt;
  std::vector<std::string> out;
  for (const JsonNode& item : found->items()) out.push_back(item.isText() ? item.text() : "");
  return ofLength(std::move(out), axes);
}

// A unit for each axis; no units if the attributes have none.
std::vector<std::string> unitsIn(const std::optional<JsonNode>& attributes, std::size_t axes) {
  if (!attributes) return {};
  const std::optional<JsonNode> size = attributes->find("pixelResolution"), units = attributes->find("units");
  const std::optional<JsonNode> unit = size ? size->findIn("unit") : std::nullopt;
  if (unit && unit->isText()) return {axes, unit->text()};
  if (units && units->isText()) return {axes, units->text()};
  return textsAt(attributes, "units", axes).value_or(std::vector<std::string>());
}

// The transformation of an array of OpenOrganelle, whose lists begin with the slowest axis unless its ordering is "F".
bool transformN5(const std::optional<JsonNode>& attributes, std::vector<ArrayAxis>& axes) {
  const std::optional<JsonNode> transform = attributes ? attributes->find("transform") : std::nullopt;
  if (!transform || !transform->isObject()) return false;
  const std::size_t count = axes.size();
  const std::optional<std::vector<double>> scale = lengthsAt(transform, "scale", count),
                                           place = lengthsAt(transform, "translate", count);
  if (!scale) return false;
  const auto names = textsAt(transform, "axes", count), units = textsAt(transform, "units", count);
  const std::optional<JsonNode> ordering = transform->find("ordering");
  const bool x_first = ordering && ordering->isText() && ordering->text() == "F";
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t from = x_first ? i : count - 1 - i;
    axes[i].scale = (*scale)[from];
    axes[i].translation = place ? (*place)[from] : 0;
    if (names) axes[i].name = (*names)[from];
    if (units) axes[i].unit = (*units)[from];
  }
  return true;
}

// The factors of an array in the list of its group, which has two names (neuroglancer).
std::optional<std::vector<double>> factorsInGroup(const JsonNode& above, std::size_t scale, std::size_t axes) {
  for (const char* const key : {"scales", "downsamplingFactors"}) {
    const std::optional<JsonNode> scales = above.find(key);
    if (!scales || !scales->isList()) continue;
    const std::vector<JsonNode> items = scales->items();
    if (scale < items.size() && items[scale].isList()) return numbersIn(items[scale], axes);
  }
  return std::nullopt;
}

// Neuroglancer marks channels by ^ and axes local to a layer by '.
std::string withoutMark(std::string name) {
  if (name.size() > 1 && (name.back() == '^' || name.back() == '\'')) name.pop_back();
  return name;
}

}  // namespace

bool placeN5(const ZarrArray& array, const std::optional<JsonNode>& above, std::optional<std::size_t> scale,
             std::vector<ArrayAxis>& axes) {
  const std::optional<JsonNode>& own = array.attributes;
  const std::size_t count = axes.size();
  auto names = textsAt(own, "axes", count);
  if (!names) names = textsAt(above, "axes", count);
  for (std::size_t i = 0; names && i < count; ++i) axes[i].name = withoutMark((*names)[i]);
  if (transformN5(own, axes)) return true;
  const auto lengths = [&](const char* key) {
    const auto found = lengthsAt(own, key, count);
    return found ? found : lengthsAt(above, key, count);
  };
  const auto sizeIn = [&](const std::optional<JsonNode>& attributes) {
    const auto found = lengthsAt(attributes, "pixelResolution", count);
    return found ? found : lengthsAt(attributes, "resolution", count);
  };
  std::optional<std::vector<double>> size = sizeIn(own), factors = lengthsAt(own, "downsamplingFactors", count);
  if (!size) {
    size = sizeIn(above);
    // The group's size is that of its finest array; an array's own size counts as it is.
    if (!factors && above && scale) factors = factorsInGroup(*above, *scale, count);
  }
  if (!size) return false;
  std::optional<std::vector<double>> offset = lengths("offset");
  if (!offset) offset = lengths("translate");
  std::vector<std::string> units = unitsIn(own, count);
  if (units.empty()) units = unitsIn(above, count);
  units.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double factor = factors ? (*factors)[i] : 1;
    axes[i].unit = units[i];
    axes[i].scale = (*size)[i] * factor;
    // A coarser voxel covers `factor` finer ones; its centre lies half of the difference behind the first.
    axes[i].translation = (offset ? (*offset)[i] : 0) + (*size)[i] * (factor - 1) / 2;
  }
  return true;
}

}  // namespace kiln
