#include "engine/shared/classifier.h"

#include <algorithm>

namespace kiln {
namespace {

auto firstPointAtOrAbove(const TransferFunction& function, double value) {
  return std::lower_bound(function.points.begin(), function.points.end(), value,
                          [](const TransferPoint& point, double v) { return point.value < v; });
}

auto firstPointAbove(const TransferFunction& function, double value) {
  return std::upper_bound(function.points.begin(), function.points.end(), value,
                          [](double v, const TransferPoint& point) { return v < point.value; });
}

// Returns false if the function has regions, and none has values of the range.
bool inSomeRegion(const TransferFunction& function, const ValueRange& range) {
  const auto& regions = function.regions;
  return regions.empty() || std::any_of(regions.begin(), regions.end(), [&](const GradientRegion& region) {
           return region.opacity > 0 && region.values.x <= range.hi && region.values.y >= range.lo;
         });
}

}  // namespace

Classifier::Classifier(const TransferFunction& function, double unit, VoxelType type, const ValueRange& range)
    : function_(function), unit_(unit), opaque_points_before_(1, 0) {
  for (const TransferPoint& point : function.points) {
    opaque_points_before_.push_back(opaque_points_before_.back() + (point.opacity > 0 ? 1 : 0));
  }
  if (sizeOf(type) <= 2 && !range.empty()) {
    first_ = static_cast<int>(range.lo);
    for (int value = first_; value <= static_cast<int>(range.hi); ++value) {
      table_.push_back(evaluate(value));
      shown_.push_back(table_.back().tau > 0 ? 1 : 0);
    }
    const auto begin = std::find(shown_.begin(), shown_.end(), 1), end = std::find(begin, shown_.end(), 0);
    if (begin != end && std::find(end, shown_.end(), 1) == shown_.end()) {
      shown_interval_ = {first_ + static_cast<int>(begin - shown_.begin()),
                         first_ + static_cast<int>(end - shown_.begin()) - 1};
    }
  }
}

Material Classifier::evaluate(double value) const {
  const Classified c = function_.at(value);
  Material out;
  if (!(c.opacity > 0)) return out;
  out.r = static_cast<float>(c.color.r);
  out.g = static_cast<float>(c.color.g);
  out.b = static_cast<float>(c.color.b);
  out.tau = static_cast<float>(extinctionOf(c.opacity, unit_));
  return out;
}

bool Classifier::interesting(const ValueRange& range) const {
  if (range.empty()) return false;
  if (!function_.labels.empty()) return function_.labelsShownIn(range.lo, range.hi);
  if (!function_.surfaces.empty()) return function_.surfacesCrossedIn(range.lo, range.hi);
  if (!inSomeRegion(function_, range)) return false;
  const auto first = firstPointAtOrAbove(function_, range.lo) - function_.points.begin();
  const auto last = firstPointAbove(function_, range.hi) - function_.points.begin();
  if (opaque_points_before_[static_cast<std::size_t>(last)] > opaque_points_before_[static_cast<std::size_t>(first)])
    return true;
  return function_.interesting(range.lo) || function_.interesting(range.hi);
}

}  // namespace kiln
