// Presets are written in commonly quoted values (Hounsfield units for CT) and mapped to the volume's values.
// "auto" splits the histogram in two by Otsu's method (Otsu 1979: the threshold with the greatest variance between the
// classes) and draws the surface of the upper class. If that class is nearly empty (a few bright voxels raise the
// threshold) or nearly everything, the other class is split again.
#include "scene/transfer/presets.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <optional>

#include "base/error.h"
#include "scene/transfer/color_map.h"
#include "scene/transfer/label_styles.h"
#include "scene/transfer/named_color_maps.h"

namespace kiln {
namespace {

// Linear light.
const glm::dvec3 kSkin{0.78, 0.50, 0.36}, kSkinLight{0.90, 0.66, 0.50}, kBone{0.88, 0.80, 0.64},
    kWhite{0.95, 0.94, 0.92};
const glm::dvec3 kFogGrey{0.62, 0.66, 0.72}, kFogWarm{1.0, 0.93, 0.82}, kSolid{0.45, 0.62, 0.80},
    kIvory{0.86, 0.82, 0.74};
constexpr double kSurfaceOpacity = 0.9;

// Voxel counts by value; bin b covers [edge(b), edge(b + 1)).
struct Bins {
  ValueHistogram histogram;

  std::size_t size() const { return histogram.counts.size(); }
  double edge(std::size_t bin) const {
    const double t = static_cast<double>(bin) / static_cast<double>(size());
    return (1 - t) * histogram.lo + t * histogram.hi;
  }
  // In doubles: 10 000³ voxels times bin numbers and squares stay far from overflow.
  double count(std::size_t first, std::size_t last) const {
    double sum = 0;
    for (std::size_t bin = first; bin < last; ++bin) sum += static_cast<double>(histogram.counts[bin]);
    return sum;
  }
};

// Returns the bin in (first, last) where Otsu's upper class begins; nothing if the bins have fewer than two distinct
// values.
std::optional<std::size_t> otsuSplit(const Bins& bins, std::size_t first, std::size_t last) {
  const double total = bins.count(first, last);
  double moment = 0;
  for (std::size_t bin = first; bin < last; ++bin) {
    moment += static_cast<double>(bin) * static_cast<double>(bins.histogram.counts[bin]);
  }
  double below = 0, below_moment = 0, best = 0;
  std::size_t lowest = 0, highest = 0;
  for (std::size_t bin = first; bin + 1 < last; ++bin) {
    below += static_cast<double>(bins.histogram.counts[bin]);
    below_moment += static_cast<double>(bin) * static_cast<double>(bins.histogram.counts[bin]);
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

// Returns the value that separates empty space from the object.
std::optional<double> surfaceValue(const Bins& bins) {
  constexpr double kFewest = 0.02, kMost = 0.70;  // share of all voxels in the upper class
  std::size_t first = 0, last = bins.size();
  std::optional<std::size_t> split = otsuSplit(bins, first, last);
  for (int again = 0; split && again < 4; ++again) {
    const double share = bins.count(*split, bins.size()) / bins.count(0, bins.size());
    if (share < kFewest)
      last = *split;
    else if (share > kMost)
      first = *split;
    else
      break;
    const std::optional<std::size_t> next = otsuSplit(bins, first, last);
    if (!next) break;
    split = next;
  }
  return split ? std::optional(bins.edge(*split)) : std::nullopt;
}

// Returns the value that a `fraction` of the voxels outside the lowest bin (empty space) do not exceed.
double highValue(const Bins& bins, double fraction, double otherwise) {
  const double total = bins.size() > 1 ? bins.count(1, bins.size()) : 0;
  double below = 0;
  for (std::size_t bin = 1; bin < bins.size() && total > 0; ++bin) {
    below += static_cast<double>(bins.histogram.counts[bin]);
    if (below >= fraction * total) return bins.edge(bin + 1);
  }
  return otherwise;
}

Bins usableBins(const Manifest& manifest) {
  const ValueHistogram& histogram = manifest.histogram;
  const bool usable = histogram.counts.size() > 1 && std::isfinite(histogram.lo) && histogram.lo < histogram.hi &&
                      std::isfinite(histogram.hi);
  return {usable ? histogram : ValueHistogram{}};
}

// Returns the opacity per mean spacing that gives the box's mean diagonal this optical depth.
double opacityForDepth(const Manifest& manifest, double optical_depth) {
  const VolumeGeometry& volume = manifest.geometry();
  const glm::dvec3 dims(volume.dims.x, volume.dims.y, volume.dims.z);
  double sum = 0;
  for (const glm::dvec3& sign :
       {glm::dvec3(1, 1, 1), glm::dvec3(-1, 1, 1), glm::dvec3(1, -1, 1), glm::dvec3(1, 1, -1)}) {
    sum += glm::length(glm::dmat3(volume.world_from_index) * (sign * dims));
  }
  const double voxels = sum / 4 / volume.meanSpacing();
  return voxels > 0 && std::isfinite(voxels) ? 1 - std::exp(-optical_depth / voxels) : 0.1;
}

ValueRange fogRange(const Manifest& manifest) {
  const ValueRange range = usableRange(manifest);
  // Empty space is 0 in a fog; in another volume, the least value.
  const double lo = manifest.volume_class == VolumeClass::kFog && range.hi > 0 ? 0 : range.lo;
  const double high = highValue(usableBins(manifest), 0.995, range.hi);
  return {lo, high > lo ? high : range.hi};
}

double fogOpacity(const Manifest& manifest) { return opacityForDepth(manifest, 6); }

TransferFunction fog(const Manifest& manifest) {
  const ValueRange range = fogRange(manifest);
  return {0, {{range.lo, kFogGrey, 0}, {range.hi, kFogWarm, fogOpacity(manifest)}}};
}

TransferFunction levelSet(const Manifest& manifest) {
  const double spacing = manifest.ownMeanSpacing();
  return {0, {{0, kSolid, 1}, {0.5 * spacing, kSolid, 0}}};
}

TransferFunction grayscale(const Manifest& manifest) {
  const ValueRange range = usableRange(manifest);
  return {0, {{range.lo, glm::dvec3(0), 0}, {range.hi, glm::dvec3(1), grayscaleOpacity(manifest)}}};
}

// Returns a named colour map over the values, with rising opacity.
TransferFunction colored(std::string_view name, const ValueRange& range, double opacity) {
  ColorMap colors = namedColorMap(name);
  stretch(colors, {0, 1}, range);
  return {0, sampled(colors, {{{range.lo, 0}, {range.hi, opacity}}})};
}

// Opaque from slightly above `surface`, brightening to `high`; for values in `range`.
TransferFunction surfaceRamp(double surface, double high, const ValueRange& range) {
  // Keeps the rise above 0 for values of any size; the width of the range itself may overflow a double.
  high = std::max(high, surface + std::max(1e-6 * std::abs(surface), 1e-12 * range.hi - 1e-12 * range.lo));
  const double rise = high - surface;
  return {0,
          {{surface, kSkin, 0},
           {surface + 0.1 * rise, kSkin, kSurfaceOpacity},
           {surface + 0.4 * rise, kSkinLight, kSurfaceOpacity},
           {high, kWhite, 0.97}}};
}

TransferFunction surfaceOf(const Manifest& manifest) {
  const Bins bins = usableBins(manifest);
  const ValueRange range = usableRange(manifest);
  const std::optional<double> surface = surfaceValue(bins);
  // A constant volume, or no histogram: a solid block is more useful than an empty picture.
  if (!surface)
    return surfaceRamp(manifest.range.lo < manifest.range.hi ? std::midpoint(range.lo, range.hi) : range.lo - 1,
                       range.hi, range);
  return surfaceRamp(*surface, highValue(bins, 0.995, range.hi), range);
}

// T1 and T2 heads: skin is darker than Otsu's threshold between air and brain. So the surface is three quarters of the
// way from the mean of the air to the threshold.
TransferFunction mrHead(const Manifest& manifest) {
  const Bins bins = usableBins(manifest);
  const std::optional<double> surface = surfaceValue(bins);
  if (!surface) return surfaceOf(manifest);
  double count = 0, sum = 0;
  for (std::size_t bin = 0; bin < bins.size() && bins.edge(bin + 1) <= *surface; ++bin) {
    count += static_cast<double>(bins.histogram.counts[bin]);
    sum += bins.edge(bin) * static_cast<double>(bins.histogram.counts[bin]);
  }
  const double air = count > 0 ? sum / count : bins.histogram.lo;
  const ValueRange range = usableRange(manifest);
  return surfaceRamp(air + 0.75 * (*surface - air), highValue(bins, 0.995, range.hi), range);
}

// Maps Hounsfield units to the volume's values. Unchanged if the range goes far below water; shifted by 1024 if the
// range starts at air = 0 (12-bit scanners, the UNC head). Else (8-bit and normalised data) the range is air to dense
// bone.
double valueOfHounsfield(const ValueRange& range, double hounsfield) {
  if (range.lo < -200) return hounsfield;
  if (range.hi > 1500 && range.hi < 20000) return hounsfield + 1024;
  return range.lo + (hounsfield + 1024) / 3272 * (range.hi - range.lo);
}

TransferFunction computedTomography(const Manifest& manifest, std::vector<TransferPoint> points_hounsfield) {
  const ValueRange range = usableRange(manifest);
  for (TransferPoint& point : points_hounsfield) point.value = valueOfHounsfield(range, point.value);
  return {0, std::move(points_hounsfield)};
}

TransferFunction automatic(const Manifest& manifest) {
  if (manifest.volume_class == VolumeClass::kLabels) return labelPalette(manifest);
  if (manifest.volume_class == VolumeClass::kFog) return fog(manifest);
  if (manifest.volume_class == VolumeClass::kLevelSet) return levelSet(manifest);
  return surfaceOf(manifest);
}

// Solid from the number `text` on. A ramp of a hundredth of the range suffices for shading without steps.
TransferFunction isoSurface(std::string_view text, const Manifest& manifest) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || !(std::abs(value) <= 1e300))
    throw Error(ErrorCode::kUsage, "'iso:" + std::string(text) + "': expected a number after iso:, such as iso:300");
  const ValueRange range = usableRange(manifest);
  const double half = std::max(0.005 * (range.hi - range.lo), 1e-9 * std::abs(value));
  return {0, {{value - half, kIvory, 0}, {value + half, kIvory, 0.97}}};
}

constexpr std::string_view kIso = "iso:";

}  // namespace

ValueRange usableRange(const Manifest& manifest) {
  ValueRange range = manifest.range;
  const ValueHistogram& histogram = manifest.histogram;
  // Manifests of an earlier version have bins up to the largest float if the volume has infinities.
  constexpr double kLargest = std::numeric_limits<float>::max();
  if (!range.empty() && ((!std::isfinite(range.lo) && histogram.lo <= -kLargest) ||
                         (!std::isfinite(range.hi) && histogram.hi >= kLargest)))
    return {0, 1};
  // Bins of labels extend half a label beyond the range.
  if (!range.empty() && histogram.lo < histogram.hi)
    range = {std::max(range.lo, histogram.lo), std::min(range.hi, histogram.hi)};
  if (range.empty() || !std::isfinite(range.lo) || !std::isfinite(range.hi)) return {0, 1};
  if (range.lo == range.hi) return {range.lo, range.lo + std::max(1.0, std::abs(range.lo) * 1e-6)};
  return range;
}

double grayscaleOpacity(const Manifest& manifest) { return opacityForDepth(manifest, 10); }

TransferFunction displayGrey(const Manifest& manifest) {
  const ValueRange range = usableRange(manifest);
  const ColorMap grey{ColorSpace::kRgb, {{range.lo, glm::dvec3(0)}, {range.hi, glm::dvec3(1)}}};
  return {0, sampled(grey, {{{range.lo, 1}, {range.hi, 1}}})};
}

const std::vector<std::string>& presetNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out = {"auto",    "ct-skin", "ct-bone",  "ct-bone-and-skin",
                                    "mr-head", "fog",     "levelset", "grayscale"};
    out.insert(out.end(), colorMapNames().begin(), colorMapNames().end());
    return out;
  }();
  return names;
}

std::string presetList() {
  std::string out;
  for (const std::string& preset : presetNames()) out += (out.empty() ? "" : ", ") + preset;
  return out + " or iso:VALUE";
}

bool isPreset(std::string_view name) {
  return name.starts_with(kIso) || std::find(presetNames().begin(), presetNames().end(), name) != presetNames().end();
}

TransferFunction presetFor(std::string_view name, const Manifest& manifest) {
  if (name == "auto") return automatic(manifest);
  if (name == "ct-skin") {
    return computedTomography(manifest,
                              {{-550, kSkin, 0}, {-350, kSkin, 0.9}, {100, kSkinLight, 0.9}, {300, kBone, 0.95}});
  }
  if (name == "ct-bone") {
    return computedTomography(manifest, {{130, kBone, 0}, {330, kBone, 0.9}, {1000, kWhite, 0.97}});
  }
  // Skin is the border to air; tissue between skin and bone would hide the bone and is left out.
  if (name == "ct-bone-and-skin") {
    return computedTomography(manifest, {{-700, kSkin, 0},
                                         {-400, kSkin, 0.1},
                                         {-200, kSkin, 0.1},
                                         {-50, kSkinLight, 0},
                                         {130, kBone, 0},
                                         {330, kBone, 0.9},
                                         {1000, kWhite, 0.97}});
  }
  if (name == "mr-head") return mrHead(manifest);
  if (name == "fog") return fog(manifest);
  if (name == "levelset") return levelSet(manifest);
  if (name == "grayscale") return grayscale(manifest);
  if (name == "fire") return colored(name, fogRange(manifest), fogOpacity(manifest));
  if (name.starts_with(kIso)) return isoSurface(name.substr(kIso.size()), manifest);
  if (isPreset(name)) return colored(name, usableRange(manifest), grayscaleOpacity(manifest));
  throw Error(ErrorCode::kUsage,
              "'" + std::string(name) + "' is not a transfer function preset; there are " + presetList());
}

}  // namespace kiln
