#include "engine/shown_depths.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace kiln {
namespace {

// Bins between the first and the last point. A bin's bound is that of its most opaque value: a threshold of opacity
// moves by less than 1/4000 of the points' span.
constexpr int kBins = 4094;

double largestFactor(const TransferFunction& function, double lo, double hi) {
  if (function.regions.empty()) return 1;
  double out = 0;
  for (const GradientRegion& region : function.regions) {
    if (region.values.x <= hi && region.values.y >= lo) out = std::max(out, region.opacity);
  }
  return out;
}

// Upper bound of the opacity of values in [lo, hi).
double largestOpacity(const TransferFunction& function, double lo, double hi) {
  double out = std::max(function.at(lo).opacity, function.at(std::nextafter(hi, lo)).opacity);
  auto point = std::ranges::lower_bound(function.points, lo, {}, &TransferPoint::value);
  for (; point != function.points.end() && point->value < hi; ++point) out = std::max(out, point->opacity);
  return out * largestFactor(function, lo, hi);
}

}  // namespace

ShownDepths::ShownDepths(std::span<const TransferFunction> functions, double mean_spacing, const ValueRange& values,
                         const Progress& progress) {
  const TransferFunction& first = functions.front();
  kind_ = !first.labels.empty() ? Kind::kLabels : !first.surfaces.empty() ? Kind::kSurfaces : Kind::kPoints;
  if (kind_ == Kind::kPoints) {
    addPoints(functions, mean_spacing, values, progress);
    return;
  }
  for (const TransferFunction& function : functions) {
    for (const LabelStyle& style : function.labels) values_.push_back(style.label);
    for (const IsoSurface& surface : function.surfaces) values_.push_back(surface.value);
  }
  std::ranges::sort(values_);
  values_.erase(std::ranges::unique(values_).begin(), values_.end());
  std::vector<float> depths(values_.size() + 1);  // number 0: below all surfaces, or a label without an entry
  for (const TransferFunction& function : functions) {
    progress.throwIfCancelled("looking for the visible box");
    const double unit = function.unitIn(mean_spacing);
    const auto include = [&](double value, double opacity, double length) {
      float& depth = depths[static_cast<std::size_t>(binOf(value))];
      depth = std::max(depth, static_cast<float>(extinctionOf(opacity, length)));
    };
    for (const LabelStyle& style : function.labels) include(style.label, style.opacity, unit);
    for (const IsoSurface& surface : function.surfaces) include(surface.value, surface.opacity, 1);
  }
  maxima_.push_back(std::move(depths));
  addMaxima();
}

void ShownDepths::addPoints(std::span<const TransferFunction> functions, double mean_spacing, const ValueRange& values,
                            const Progress& progress) {
  lo_ = std::numeric_limits<double>::infinity(), hi_ = -lo_;
  for (const TransferFunction& function : functions) {
    if (function.points.empty()) continue;
    lo_ = std::min(lo_, function.points.front().value);
    hi_ = std::max(hi_, function.points.back().value);
  }
  // Without points nothing is shown.
  std::vector<float> extinctions(kBins + 2);
  if (!(lo_ <= hi_)) lo_ = hi_ = 0;
  // Halves, as the span of values near the largest double would overflow.
  const double half = 0.5 * hi_ - 0.5 * lo_;
  bins_per_value_ = half > 0 ? 0.5 * kBins / half : 0;
  for (const TransferFunction& function : functions) {
    progress.throwIfCancelled("looking for the visible box");
    const double unit = function.unitIn(mean_spacing);
    for (int bin = 0; bin < kBins + 2; ++bin) {
      // The first and the last bin hold all values beyond the points.
      const double lo =
          bin == 0 ? std::min(values.lo, std::nextafter(lo_, -1e308)) : std::lerp(lo_, hi_, (bin - 1.0) / kBins);
      const double hi = bin > kBins ? std::max(values.hi, std::nextafter(hi_, 1e308))
                                    : std::lerp(lo_, hi_, static_cast<double>(bin) / kBins);
      if (function.points.empty() || !(lo < hi)) continue;
      float& extinction = extinctions[static_cast<std::size_t>(bin)];
      extinction = std::max(extinction, static_cast<float>(extinctionOf(largestOpacity(function, lo, hi), unit)));
    }
  }
  maxima_.push_back(std::move(extinctions));
  addMaxima();
}

void ShownDepths::addMaxima() {
  for (std::size_t run = 1; 2 * run <= maxima_.front().size(); run *= 2) {
    const std::vector<float>& half = maxima_.back();
    std::vector<float> out(half.size() - run);
    for (std::size_t bin = 0; bin < out.size(); ++bin) out[bin] = std::max(half[bin], half[bin + run]);
    maxima_.push_back(std::move(out));
  }
}

float ShownDepths::greatest(int first, int last) const {
  const auto level = static_cast<std::size_t>(std::bit_width(static_cast<unsigned>(last - first + 1)) - 1);
  const std::vector<float>& maxima = maxima_[level];
  return std::max(maxima[static_cast<std::size_t>(first)],
                  maxima[static_cast<std::size_t>(last + 1) - (std::size_t{1} << level)]);
}

int ShownDepths::binOf(double value) const {
  if (std::isnan(value)) return kNone;
  if (kind_ == Kind::kPoints) {
    if (value < lo_) return 0;
    if (value >= hi_) return kBins + 1;
    return 1 + static_cast<int>(std::min((value - lo_) * bins_per_value_, kBins - 1.0));
  }
  const auto above = static_cast<int>(std::ranges::upper_bound(values_, value) - values_.begin());
  if (kind_ == Kind::kLabels && (above == 0 || values_[static_cast<std::size_t>(above - 1)] != value)) return 0;
  return above;
}

double ShownDepths::depth(const ValueRange& range, double length) const {
  if (range.empty()) return 0;
  if (kind_ != Kind::kLabels) return depth(binOf(range.lo), binOf(range.hi), length);
  const auto first = static_cast<int>(std::ranges::lower_bound(values_, range.lo) - values_.begin()) + 1;
  const auto last = static_cast<int>(std::ranges::upper_bound(values_, range.hi) - values_.begin());
  return first <= last ? greatest(first, last) * length : 0;
}

}  // namespace kiln
