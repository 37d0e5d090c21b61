// Source: Otsu 1979, the threshold with the greatest variance between the classes.
#include "scene/transfer/value_bins.h"

#include <algorithm>
#include <cmath>

namespace kiln {

ValueBins::ValueBins(const Manifest& manifest) {
  const ValueHistogram& histogram = manifest.histogram;
  const bool usable = histogram.counts.size() > 1 && std::isfinite(histogram.lo) && histogram.lo < histogram.hi &&
                      std::isfinite(histogram.hi);
  if (usable) histogram_ = histogram;
}

double ValueBins::edge(std::size_t bin) const {
  const double t = static_cast<double>(bin) / static_cast<double>(size());
  return (1 - t) * histogram_.lo + t * histogram_.hi;
}

// In doubles: 10 000³ voxels times bin numbers and squares stay far from overflow.
double ValueBins::count(std::size_t first, std::size_t last) const {
  double sum = 0;
  for (std::size_t bin = first; bin < last; ++bin) sum += count(bin);
  return sum;
}

// Returns the bin in (first, last) where Otsu's upper class begins; nothing if the bins have fewer than two distinct
// values.
std::optional<std::size_t> ValueBins::otsuSplit(std::size_t first, std::size_t last) const {
  const double total = count(first, last);
  double moment = 0;
  for (std::size_t bin = first; bin < last; ++bin) moment += static_cast<double>(bin) * count(bin);
  double below = 0, below_moment = 0, best = 0;
  std::size_t lowest = 0, highest = 0;
  for (std::size_t bin = first; bin + 1 < last; ++bin) {
    below += count(bin);
    below_moment += static_cast<double>(bin) * count(bin);
    const double above = total - below;
    if (!(below > 0) || !(above > 0)) continue;
    const double distance = below_moment / below - (moment - below_moment) / above;
    const double between = below * above * distance * distance;
    if (between > best) lowest = bin + 1;
    if (between >= best) highest = bin + 1;
    best = std::max(best, between);
  }
  // Empty bins between the classes are equally good: takes the middle bin.
  return best > 0 ? std::optional((lowest + highest) / 2) : std::nullopt;
}

std::optional<double> ValueBins::surface() const {
  constexpr double kFewest = 0.02, kMost = 0.70;  // share of all voxels in the upper class
  std::size_t first = 0, last = size();
  std::optional<std::size_t> split = otsuSplit(first, last);
  for (int again = 0; split && again < 4; ++again) {
    const double share = count(*split, size()) / count(0, size());
    if (share < kFewest)
      last = *split;
    else if (share > kMost)
      first = *split;
    else
      break;
    const std::optional<std::size_t> next = otsuSplit(first, last);
    if (!next) break;
    split = next;
  }
  return split ? std::optional(edge(*split)) : std::nullopt;
}

double ValueBins::highValue(double fraction, double otherwise) const {
  const double total = size() > 1 ? count(1, size()) : 0;
  double below = 0;
  for (std::size_t bin = 1; bin < size() && total > 0; ++bin) {
    below += count(bin);
    if (below >= fraction * total) return edge(bin + 1);
  }
  return otherwise;
}

double ValueBins::valueExceededBy(double share, double otherwise) const {
  const double total = count(0, size());
  double above = 0;
  for (std::size_t bin = size(); bin > 0 && total > 0; --bin) {
    above += count(bin - 1);
    if (above > share * total) return edge(bin);
  }
  return otherwise;
}

}  // namespace kiln
