// Reasons and figures: decisions/projection-ranges.md.
#include "scene/transfer/projection_range.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "scene/transfer/preset_ranges.h"
#include "scene/transfer/value_bins.h"

namespace kiln {
namespace {

// Share of the voxels below a minimum's window, and most above a maximum's, as in slices (display_map.h).
constexpr double kBeyond = 0.005;
// Most pixels of a maximum beyond the window, and the least depth of what is bright. unit: of a face; voxels.
constexpr double kPixelsBeyond = 0.01, kDepthOfBright = 3;
// Noise of empty space that stays black. unit: standard deviations. Maxima of 256 samples of noise lie 2.8 above.
constexpr double kNoise = 2;
constexpr double kBelowDeviation = 0.16;  // share of a normal distribution below one standard deviation

// Returns the value below which `voxels` of the voxels from bin `first` on lie; linear within a bin.
double valueAbove(const ValueBins& bins, double voxels, std::size_t first = 0) {
  for (std::size_t bin = first; bin < bins.size(); ++bin) {
    const double count = bins.count(bin);
    if (count > 0 && voxels <= count)
      return std::lerp(bins.edge(bin), bins.edge(bin + 1), std::max(voxels, 0.0) / count);
    voxels -= count;
  }
  return bins.edge(bins.size());
}

std::size_t firstBinFrom(const ValueBins& bins, double value) {
  std::size_t bin = 0;
  while (bin < bins.size() && bins.edge(bin) < value) ++bin;
  return bin;
}

// Number of voxels behind a pixel of a view along the longest axis.
double longestEdge(const Manifest& manifest) {
  const Extent3& dims = manifest.geometry().dims;
  return static_cast<double>(std::max({dims.x, dims.y, dims.z, std::int64_t{1}}));
}

// Values of empty space, below Otsu's threshold: the middle, and how far noise spreads.
struct EmptySpace {
  double middle, deviation;
};

EmptySpace emptySpaceOf(const ValueBins& bins, double surface) {
  const double empty = bins.count(0, firstBinFrom(bins, surface));
  const double middle = valueAbove(bins, 0.5 * empty);
  return {middle, middle - valueAbove(bins, kBelowDeviation * empty)};
}

// From above the noise of empty space to the value that few pixels exceed.
ValueRange ofMaxima(const ValueBins& bins, double surface, const Manifest& manifest) {
  const EmptySpace empty = emptySpaceOf(bins, surface);
  const double bright = std::min(kPixelsBeyond * kDepthOfBright / longestEdge(manifest), kBeyond);
  return {std::min(surface, empty.middle + kNoise * empty.deviation),
          valueAbove(bins, (1 - bright) * bins.count(0, bins.size()))};
}

// To the middle of the object's values: a ray that meets only brighter values is rare.
ValueRange ofMinima(const ValueBins& bins, double surface) {
  const double all = bins.count(0, bins.size());
  const std::size_t first = firstBinFrom(bins, surface);
  return {valueAbove(bins, kBeyond * all), valueAbove(bins, 0.5 * bins.count(first, bins.size()), first)};
}

// From the mean of empty space to the mean along a ray through the middle of concentric bodies: the body of all values
// above v, a share s of the shown box, covers the cube root of s of the ray. The mean is the integral of the covered
// part over v.
ValueRange ofMeans(const ValueBins& bins, double surface, double shown) {
  const double all = bins.count(0, bins.size());
  const double lo = emptySpaceOf(bins, surface).middle;
  double above = all, hi = lo;
  for (std::size_t bin = 0; bin < bins.size(); ++bin) {
    above -= 0.5 * bins.count(bin);
    const double width = bins.edge(bin + 1) - std::max(bins.edge(bin), lo);
    if (width > 0) hi += width * std::cbrt(std::min(above / (all * shown), 1.0));
    above -= 0.5 * bins.count(bin);
  }
  return {lo, hi};
}

}  // namespace

ValueRange projectionRange(const Manifest& manifest, Mode mode, double shown) {
  const ValueRange all = usableRange(manifest);
  const ValueBins bins(manifest);
  const std::optional<double> surface = bins.surface();
  if (!surface || manifest.volume_class == VolumeClass::kLevelSet) return all;
  const ValueRange found = mode == Mode::kAverage ? ofMeans(bins, *surface, shown)
                           : mode == Mode::kMinip ? ofMinima(bins, *surface)
                                                  : ofMaxima(bins, *surface, manifest);
  const ValueRange out{std::max(all.lo, found.lo), std::min(all.hi, found.hi)};
  return out.lo < out.hi ? out : all;
}

}  // namespace kiln
