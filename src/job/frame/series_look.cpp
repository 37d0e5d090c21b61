#include "job/frame/series_look.h"

#include <algorithm>
#include <cmath>

#include "scene/camera/framing.h"

namespace kiln {
namespace {

double binWidth(const ValueHistogram& histogram) {
  return (histogram.hi - histogram.lo) / static_cast<double>(histogram.counts.size());
}

bool hasBins(const ValueHistogram& histogram) { return histogram.lo < histogram.hi && !histogram.counts.empty(); }

// Adds each bin of `from` to the overlapping bins of `to`, in proportion; the remainder goes to the first bin.
void addBins(const ValueHistogram& from, ValueHistogram& to) {
  const double width = binWidth(to), of_from = binWidth(from);
  const auto last = static_cast<double>(to.counts.size() - 1);
  const auto binOf = [&](double value) {
    return static_cast<std::size_t>(std::clamp(std::floor((value - to.lo) / width), 0.0, last));
  };
  for (std::size_t i = 0; i < from.counts.size(); ++i) {
    const double lo = from.lo + static_cast<double>(i) * of_from;
    // A millionth of a bin is rounding.
    const std::size_t first = binOf(lo + 1e-6 * width), end = std::max(binOf(lo + of_from - 1e-6 * width), first) + 1;
    const std::uint64_t share = from.counts[i] / (end - first);
    for (std::size_t bin = first; bin < end; ++bin) to.counts[bin] += share;
    to.counts[first] += from.counts[i] - share * (end - first);
  }
}

// Labels keep a bin each.
ValueHistogram sumOf(const std::vector<Manifest>& frames, const Manifest& all) {
  ValueHistogram out = frames.front().histogram;
  for (const Manifest& frame : frames) {
    if (!hasBins(frame.histogram)) continue;
    if (!hasBins(out)) out = frame.histogram;
    out.lo = std::min(out.lo, frame.histogram.lo);
    out.hi = std::max(out.hi, frame.histogram.hi);
  }
  if (!hasBins(out)) return out;
  std::size_t bins = 0;
  for (const Manifest& frame : frames) bins = std::max(bins, frame.histogram.counts.size());
  if (countsEachLabel(all.volume_class, all.type, all.range))
    bins = static_cast<std::size_t>(std::llround(all.range.hi - all.range.lo)) + 1;
  out.counts.assign(bins, 0);
  for (const Manifest& frame : frames) {
    if (hasBins(frame.histogram)) addBins(frame.histogram, out);
  }
  return out;
}

}  // namespace

Manifest unionOf(const std::vector<Manifest>& frames) {
  Manifest out = frames.front();
  if (frames.size() == 1) return out;
  std::vector<VolumeGeometry> boxes;
  for (const Manifest& frame : frames) {
    boxes.push_back(frame.geometry());
    out.range.include(frame.range);
    if (&frame != &frames.front()) out.nan_count += frame.nan_count;
  }
  out.levels.front().geometry = boxAround(boxes);
  out.histogram = sumOf(frames, out);
  return out;
}

}  // namespace kiln
