#include "engine/pixel/voxels/sample_table.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vec3.hpp>
#include <limits>

#include "engine/shared/classified_range.h"

namespace kiln {
namespace {

// Number of entries for types other than whole numbers of up to 16 bits.
constexpr double kTableSteps = 1 << 15;

// Limit of the change of optical depth, or of light, over the values of a soft voxel (figures: decisions/pairs.md).
constexpr double kSoftChange = 1;

// Limits of the change in an even voxel: share of the larger extinction, and optical depth (figures:
// decisions/pairs.md).
constexpr double kEvenShare = 0.9;
constexpr double kFaintChange = 1.0 / 16;

// Largest difference of two materials in extinction or emitted light.
double changeBetween(const Material& a, const Material& b) {
  const auto light = [](const Material& m) { return glm::dvec3(m.r, m.g, m.b) * static_cast<double>(m.tau); };
  const glm::dvec3 change = glm::abs(light(b) - light(a));
  return std::max({change.r, change.g, change.b, std::abs(static_cast<double>(b.tau) - static_cast<double>(a.tau))});
}

}  // namespace

SampleTable::SampleTable(const TransferFunction& function, double unit, VoxelType type, const ValueRange& all)
    : unit_(unit) {
  const bool whole = withVoxelType(type, []<class T>(std::type_identity<T>) { return sizeof(T) <= 2; });
  const ValueRange range = whole ? all : classifiedRange(function, all);
  const double lo = range.empty() ? 0 : range.lo, hi = range.empty() ? 0 : range.hi;
  lo_ = lo;
  if (!function.labels.empty()) {
    addLabels(function.labels, unit);
    return;
  }
  if (!function.surfaces.empty()) {
    // Floats are most precise near zero, and so near the first surface.
    if (!whole) lo_ = function.surfaces.front().value;
    addSurfaces(function.surfaces);
    return;
  }
  const double steps = whole ? hi - lo : kTableSteps;
  const double step = hi > lo ? (hi - lo) / steps : 1;
  scale_ = static_cast<float>(1 / step);
  last_ = static_cast<float>(std::max(0.0, std::round((hi - lo) / step)));
  const auto count = static_cast<std::size_t>(last_) + 2;
  if (function.usesGradient()) plane_ = PlaneTable(function);
  entries_.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double value = lo + static_cast<double>(i) * step;
    Classified c = function.at(std::min(hi, value));
    // Samples between this entry and its neighbours are invisible, too.
    if (plane_.any() && !plane_.shows(value - step, value + step)) c.opacity = 0;
    entries_.push_back({static_cast<float>(c.color.r), static_cast<float>(c.color.g), static_cast<float>(c.color.b),
                        c.opacity > 0 ? static_cast<float>(extinctionOf(c.opacity, unit)) : 0.0f});
  }
  extinctions_.reserve(count);
  for (const Material& m : entries_) extinctions_.push_back(m.tau);
  const auto visible = [](float tau) { return tau > 0; };
  const auto first = std::find_if(extinctions_.begin(), extinctions_.end(), visible);
  const auto last = std::find_if(extinctions_.rbegin(), extinctions_.rend(), visible);
  if (first != extinctions_.end()) {
    visible_after_ = static_cast<float>(first - extinctions_.begin() - 1);
    visible_before_ = static_cast<float>(extinctions_.rend() - last);
  }
  double sum = 0;
  integral_.reserve(count);
  integral_.assign(1, 0.0f);
  for (std::size_t i = 1; i < count; ++i) {
    sum += 0.5 * (static_cast<double>(entries_[i - 1].tau) + static_cast<double>(entries_[i].tau));
    integral_.push_back(static_cast<float>(sum));
  }
  // The last digit of a float sum is then at most a thousandth of the integral over the interval.
  least_interval_ = std::max(1.0f, static_cast<float>(count) / (1 << 12));
  before_.assign(count + 1, 0);
  for (std::size_t i = 0; i < count; ++i) before_[i + 1] = before_[i] + (entries_[i].tau > 0 ? 1 : 0);
  one_interval_ = static_cast<float>(before_.back()) == visible_before_ - visible_after_ - 1;
  changes_.reserve(count);
  changes_.assign(1, 0.0);
  for (std::size_t i = 1; i < count; ++i)
    changes_.push_back(changes_.back() + changeBetween(entries_[i - 1], entries_[i]));
  findSameColors();
}

void SampleTable::findSameColors() {
  same_until_.resize(entries_.size());
  for (std::size_t i = entries_.size(); i-- > 0;) {
    const Material& here = entries_[i];
    const bool last = i + 1 == entries_.size();
    const Material& next = entries_[last ? i : i + 1];
    const bool same = here.r == next.r && here.g == next.g && here.b == next.b;
    same_until_[i] = same && !last ? same_until_[i + 1] : static_cast<std::uint32_t>(i);
  }
}

void SampleTable::addSurfaces(const std::vector<IsoSurface>& surfaces) {
  of_surfaces_ = true;
  for (const IsoSurface& surface : surfaces) {
    if (!(surface.opacity > 0)) continue;
    surface_values_.push_back(floatOf(surface.value));
    surface_opacities_.push_back(static_cast<float>(surface.opacity));
    const glm::vec3 color(surface.color);
    entries_.push_back({color.r, color.g, color.b, 0});
  }
  last_ = static_cast<float>(std::max<std::size_t>(entries_.size(), 1) - 1);
  // An extra entry after the last, and a single entry if no surface is visible.
  const std::size_t count = static_cast<std::size_t>(last_) + 2;
  entries_.resize(count, entries_.empty() ? Material{} : entries_.back());
  extinctions_.assign(count, 0.0f);
  integral_.assign(count, 0.0f);
}

void SampleTable::addLabels(const std::vector<LabelStyle>& looks, double unit) {
  of_labels_ = true;
  visible_before_ = std::numeric_limits<float>::max();
  for (const LabelStyle& look : looks) {
    if (!(look.opacity > 0)) continue;
    labels_.push_back(static_cast<float>(look.label - lo_));
    label_opacities_.push_back(static_cast<float>(look.opacity));
    const glm::vec3 color(look.color);
    for (const float tau : {0.0f, static_cast<float>(extinctionOf(look.opacity, unit))}) {
      entries_.push_back({color.r, color.g, color.b, tau});
      extinctions_.push_back(tau);
    }
  }
  last_ = static_cast<float>(std::max<std::size_t>(entries_.size(), 1) - 1);
  // An extra entry after the last, and a single entry if no label is visible.
  const std::size_t count = static_cast<std::size_t>(last_) + 2;
  entries_.resize(count, entries_.empty() ? Material{} : entries_.back());
  extinctions_.resize(count, entries_.back().tau);
  integral_.assign(count, 0.0f);
}

bool SampleTable::interestingInParts(const ValueRange& range) const {
  if (range.empty()) return false;
  if (of_labels_) {
    const auto first = std::lower_bound(labels_.begin(), labels_.end(), static_cast<float>(range.lo - lo_));
    return first != labels_.end() && static_cast<double>(*first) <= range.hi - lo_;
  }
  if (of_surfaces_) {
    const auto first = std::upper_bound(surface_values_.begin(), surface_values_.end(), floatOf(range.lo));
    return first != surface_values_.end() && *first <= floatOf(range.hi);
  }
  return before_[entryAbove(range.hi) + 1] > before_[entryBelow(range.lo)];
}

double SampleTable::changeOver(const ValueRange& range) const {
  return changes_[entryAbove(range.hi)] - changes_[entryBelow(range.lo)];
}

bool SampleTable::soft(const ValueRange& range, double length) const {
  return !of_surfaces_ && kSoftChange / length >= changeOver(range);
}

bool SampleTable::even(const ValueRange& range, double length) const {
  const double change = changeOver(range);
  const float larger = std::max(extinctions_[entryBelow(range.lo)], extinctions_[entryAbove(range.hi)]);
  return change * length <= kFaintChange || change <= kEvenShare * static_cast<double>(larger);
}

// Includes an entry below the range: interpolation may round a value to just outside the range.
const float* SampleTable::oneColor(const ValueRange& range) const {
  if (of_surfaces_) return surface_values_.size() == 1 ? &entries_.front().r : nullptr;
  const std::size_t below = entryBelow(range.lo), from = below - (below > 0 ? 1 : 0);
  return same_until_[from] > entryAbove(range.hi) ? &entries_[from].r : nullptr;
}

std::size_t SampleTable::entryBelow(double value) const { return static_cast<std::size_t>(entryPlaceOf(value)); }

std::size_t SampleTable::entryAbove(double value) const {
  const float place = entryPlaceOf(value);
  const auto whole = static_cast<std::size_t>(place);
  return static_cast<float>(whole) < place ? whole + 1 : whole;
}

}  // namespace kiln
