// Presets are written in commonly quoted values (Hounsfield units for CT) and mapped to the volume's values.
// "auto" draws the surface between empty space and the object, which the histogram shows (value_bins.h).
#include "scene/transfer/presets.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <optional>

#include "base/error.h"
#include "base/nearest_word.h"
#include "base/text.h"
#include "image/srgb.h"
#include "scene/scene_limits.h"
#include "scene/transfer/color_map.h"
#include "scene/transfer/ct_presets.h"
#include "scene/transfer/iso_surfaces.h"
#include "scene/transfer/label_styles.h"
#include "scene/transfer/named_color_maps.h"
#include "scene/transfer/preset_ranges.h"
#include "scene/transfer/tissue_colors.h"
#include "scene/transfer/value_bins.h"

namespace kiln {
namespace {

// Linear light.
const glm::dvec3 kFogGrey{0.62, 0.66, 0.72}, kFogWarm{1.0, 0.93, 0.82}, kSolid{0.45, 0.62, 0.80};
constexpr double kSurfaceOpacity = 0.9;

// unit: world.
double meanDiagonal(const Manifest& manifest) {
  const VolumeGeometry& volume = manifest.geometry();
  const glm::dvec3 dims(volume.dims.x, volume.dims.y, volume.dims.z);
  double sum = 0;
  for (const glm::dvec3& sign :
       {glm::dvec3(1, 1, 1), glm::dvec3(-1, 1, 1), glm::dvec3(1, -1, 1), glm::dvec3(1, 1, -1)}) {
    sum += glm::length(glm::dmat3(volume.world_from_index) * (sign * dims));
  }
  return sum / 4;
}

// Returns the opacity per mean spacing that gives the box's mean diagonal this optical depth.
double opacityForDepth(const Manifest& manifest, double optical_depth) {
  const double voxels = meanDiagonal(manifest) / manifest.geometry().meanSpacing();
  return voxels > 0 && std::isfinite(voxels) ? 1 - std::exp(-optical_depth / voxels) : 0.1;
}

ValueRange fogRange(const Manifest& manifest) {
  const ValueRange range = usableRange(manifest);
  // Empty space is 0 in a fog; in another volume, the least value.
  const double lo = manifest.volume_class == VolumeClass::kFog && range.hi > 0 ? 0 : range.lo;
  const double high = ValueBins(manifest).highValue(0.995, range.hi);
  return {lo, high > lo ? high : range.hi};
}

double fogOpacity(const Manifest& manifest) { return opacityForDepth(manifest, 6); }

TransferFunction fog(const Manifest& manifest) {
  const ValueRange range = fogRange(manifest);
  TransferFunction out{0, {{range.lo, kFogGrey, 0}, {range.hi, kFogWarm, fogOpacity(manifest)}}};
  out.scattering.emplace();
  return out;
}

// White, and so dense that light of one side does not reach the other.
TransferFunction cloud(const Manifest& manifest) {
  constexpr double kDepth = 60, kForward = 0.3;
  const ValueRange range = fogRange(manifest);
  TransferFunction out{0, {{range.lo, tint::kWhite, 0}, {range.hi, tint::kWhite, opacityForDepth(manifest, kDepth)}}};
  out.scattering = {1, kForward};
  return out;
}

TransferFunction levelSet(const Manifest& manifest) {
  const double spacing = manifest.ownMeanSpacing();
  return {0, {{0, kSolid, 1}, {0.5 * spacing, kSolid, 0}}};
}

// In linear light, as black and white are the only colours.
TransferFunction grayscale(const Manifest& manifest) {
  const ValueRange range = colorMapRange(manifest);
  const OpacityCurve opacity = risingOpacity(range, manifest);
  TransferFunction out;
  for (const OpacityNode& node : opacity.nodes) {
    const auto before = static_cast<double>(out.points.size());  // the nodes are evenly spaced
    out.points.push_back(
        {node.value, glm::dvec3(before / static_cast<double>(opacity.nodes.size() - 1)), node.opacity});
  }
  return out;
}

// Returns a named colour map over the values, with rising opacity.
TransferFunction colored(std::string_view name, const Manifest& manifest) {
  const ValueRange range = colorMapRange(manifest);
  ColorMap colors = namedColorMap(name);
  stretch(colors, {0, 1}, range);
  return {0, sampled(colors, risingOpacity(range, manifest))};
}

// Returns a value not below `high` and clearly above `surface`, for values of any size in `range`, whose width may
// overflow a double.
double clearlyAbove(double surface, double high, const ValueRange& range) {
  return std::max(high, surface + std::max(1e-6 * std::abs(surface), 1e-12 * range.hi - 1e-12 * range.lo));
}

// Opaque from slightly above `surface`, brightening to `high`; for values in `range`.
TransferFunction surfaceRamp(double surface, double high, const ValueRange& range) {
  const double top = clearlyAbove(surface, high, range), rise = top - surface;
  return {0,
          {{surface, tint::kSkin, 0},
           {surface + 0.1 * rise, tint::kSkin, kSurfaceOpacity},
           {surface + 0.4 * rise, tint::kSkinLight, kSurfaceOpacity},
           {top, tint::kWhite, 0.97}}};
}

TransferFunction surfaceOf(const Manifest& manifest) {
  const ValueBins bins(manifest);
  const ValueRange range = usableRange(manifest);
  const std::optional<double> surface = bins.surface();
  // A constant volume, or no histogram: a solid block is more useful than an empty picture.
  if (!surface)
    return surfaceRamp(manifest.range.lo < manifest.range.hi ? std::midpoint(range.lo, range.hi) : range.lo - 1,
                       range.hi, range);
  return surfaceRamp(*surface, bins.highValue(0.995, range.hi), range);
}

// T1 and T2 heads: skin is darker than Otsu's threshold between air and brain. So the surface is three quarters of the
// way from the mean of the air to the threshold.
TransferFunction mrHead(const Manifest& manifest) {
  const ValueBins bins(manifest);
  const std::optional<double> surface = bins.surface();
  if (!surface) return surfaceOf(manifest);
  double count = 0, sum = 0;
  for (std::size_t bin = 0; bin < bins.size() && bins.edge(bin + 1) <= *surface; ++bin) {
    count += bins.count(bin);
    sum += bins.edge(bin) * bins.count(bin);
  }
  const double air = count > 0 ? sum / count : bins.edge(0);
  const ValueRange range = usableRange(manifest);
  return surfaceRamp(air + 0.75 * (*surface - air), bins.highValue(0.995, range.hi), range);
}

// The surface of a brain without its skull: grey matter is between fluid and the brighter white matter.
TransferFunction mrBrain(const Manifest& manifest) {
  const ValueBins bins(manifest);
  const std::optional<double> surface = bins.surface();
  if (!surface) return surfaceOf(manifest);
  const ValueRange range = usableRange(manifest);
  const double top = clearlyAbove(*surface, bins.highValue(0.995, range.hi), range), rise = top - *surface;
  return {0,
          {{*surface, tint::kCortex, 0},
           {*surface + 0.1 * rise, tint::kCortex, 0.7},
           {*surface + 0.4 * rise, tint::kWhiteMatter, 0.9},
           {top, tint::kWhite, 0.95}}};
}

// Blood that flows is the brightest in an angiogram; vessels are about a hundredth of the volume.
TransferFunction mrAngiogram(const Manifest& manifest) {
  const ValueBins bins(manifest);
  const ValueRange range = usableRange(manifest);
  const double first = bins.valueExceededBy(0.015, range.lo);
  const double solid = std::max(first, bins.valueExceededBy(0.005, range.hi));
  const double high = clearlyAbove(solid, bins.valueExceededBy(0.0005, range.hi), range);
  return {0, {{first, tint::kBlood, 0}, {solid, tint::kBlood, 0.5}, {high, tint::kBloodLight, 0.95}}};
}

// Maps Hounsfield units to the volume's values. Unchanged if the range goes far below water; shifted by 1024 if the
// range starts at air = 0 (12-bit scanners, the UNC head). Else (8-bit and normalised data) the range is air to dense
// bone.
double valueOfHounsfield(const ValueRange& range, double hounsfield) {
  if (range.lo < -200) return hounsfield;
  if (range.hi > 1500 && range.hi < 20000) return hounsfield + 1024;
  return range.lo + (hounsfield + 1024) / 3272 * (range.hi - range.lo);
}

// Returns the length of OpacityLength::kObject, 0 for a voxel: a volume of more voxels is as transparent as the same
// volume of fewer voxels.
double lengthInObject(const Manifest& manifest) {
  constexpr double kVoxelsAcross = 768;  // the diagonal of 512 x 512 x 256 voxels, a CT of a head
  const double length = meanDiagonal(manifest) / kVoxelsAcross;
  return length > manifest.geometry().meanSpacing() && std::isfinite(length) ? length : 0;
}

TransferFunction computedTomography(const CtPreset& preset, const Manifest& manifest) {
  const ValueRange range = usableRange(manifest);
  TransferFunction out{preset.length == OpacityLength::kObject ? lengthInObject(manifest) : 0, preset.points};
  for (TransferPoint& point : out.points) point.value = valueOfHounsfield(range, point.value);
  out.shaded = preset.shaded;
  return out;
}

const CtPreset* ctPresetNamed(std::string_view name) {
  for (const CtPreset& preset : ctPresets()) {
    if (preset.name == name) return &preset;
  }
  return nullptr;
}

ColorMap declaredColors(const DeclaredLook::Ramp& ramp) {
  return {ColorSpace::kRgb, {{ramp.begin, glm::dvec3(0)}, {ramp.end, srgbOf(ramp.color)}}};
}

TransferFunction automatic(const Manifest& manifest) {
  if (manifest.volume_class == VolumeClass::kLabels) return labelPalette(manifest);
  if (manifest.volume_class == VolumeClass::kFog) return fog(manifest);
  if (manifest.volume_class == VolumeClass::kLevelSet) return levelSet(manifest);
  if (manifest.look.ramp) {
    const DeclaredLook::Ramp& ramp = *manifest.look.ramp;
    return {0, sampled(declaredColors(ramp), risingOpacity({ramp.begin, ramp.end}, manifest))};
  }
  return surfaceOf(manifest);
}

constexpr std::string_view kSolidFrom = "solid:";

// Number of a "solid:" name. throws: Error kUsage.
double solidValue(std::string_view name) {
  const std::optional<double> number = numberOf<double>(name.substr(kSolidFrom.size()));
  if (!number || !(std::abs(*number) <= kLargestValue))
    throw Error(ErrorCode::kUsage, "'" + std::string(name) + "': expected a number after solid:, such as solid:300");
  return *number;
}

// Solid from `value` on. A ramp of a hundredth of the range suffices for shading without steps.
TransferFunction solidFrom(double value, const Manifest& manifest) {
  const ValueRange range = usableRange(manifest);
  const double half = std::max(0.005 * (range.hi - range.lo), 1e-9 * std::abs(value));
  const glm::dvec3 color = IsoSurface().color;
  return {0, {{value - half, color, 0}, {value + half, color, 0.97}}};
}

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

ValueRange colorMapRange(const Manifest& manifest) {
  if (manifest.volume_class == VolumeClass::kFog) return fogRange(manifest);
  const ValueBins bins(manifest);
  const ValueRange range = usableRange(manifest);
  const std::optional<double> surface = bins.surface();
  if (!surface) return range;
  return {*surface, clearlyAbove(*surface, bins.highValue(0.995, range.hi), range)};
}

OpacityCurve risingOpacity(const ValueRange& range, const Manifest& manifest) {
  if (manifest.volume_class == VolumeClass::kFog) return {{{range.lo, 0}, {range.hi, fogOpacity(manifest)}}};
  // Optical depths of the whole box: a head's soft tissue is a veil, its bone a surface.
  constexpr double kMiddle = 60, kEnd = 300;
  return {{{range.lo, 0},
           {std::midpoint(range.lo, range.hi), opacityForDepth(manifest, kMiddle)},
           {range.hi, opacityForDepth(manifest, kEnd)}}};
}

TransferFunction displayRamp(const Manifest& manifest, const ValueRange& range,
                             const std::optional<glm::dvec3>& color) {
  DeclaredLook::Ramp ramp = manifest.look.ramp.value_or(DeclaredLook::Ramp{range.lo, range.hi, {}});
  const SrgbBytes& bytes = SrgbBytes::all();
  if (color) ramp.color = {bytes.of(color->r), bytes.of(color->g), bytes.of(color->b)};
  return {0, sampled(declaredColors(ramp), {{{ramp.begin, 1}, {ramp.end, 1}}})};
}

const std::vector<std::string>& presetNames() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out = {"auto"};
    for (const CtPreset& preset : ctPresets()) out.emplace_back(preset.name);
    out.insert(out.end(), {"mr-head", "mr-brain", "mr-angio", "fog", "cloud", "levelset", "grayscale"});
    out.insert(out.end(), colorMapNames().begin(), colorMapNames().end());
    return out;
  }();
  return names;
}

std::string presetList() {
  std::string out;
  for (const std::string& preset : presetNames()) out += (out.empty() ? "" : ", ") + preset;
  return out + ", iso:VALUE,... or solid:VALUE";
}

std::string presetHint(std::string_view text) {
  const std::vector<std::string_view> names(presetNames().begin(), presetNames().end());
  return meantWordHint(text, names);
}

bool isStretched(std::string_view name) {
  return name == "grayscale" || std::ranges::find(colorMapNames(), name) != colorMapNames().end();
}

bool isPreset(std::string_view name) {
  return name.starts_with(kIso) || name.starts_with(kSolidFrom) ||
         std::find(presetNames().begin(), presetNames().end(), name) != presetNames().end();
}

void requirePresetNumbers(std::string_view name) {
  if (name.starts_with(kIso)) isoSurfaces(name.substr(kIso.size()));
  if (name.starts_with(kSolidFrom)) solidValue(name);
}

TransferFunction presetFor(std::string_view name, const Manifest& manifest) {
  if (name == "auto") return automatic(manifest);
  if (const CtPreset* const preset = ctPresetNamed(name)) return computedTomography(*preset, manifest);
  if (name == "mr-head") return mrHead(manifest);
  if (name == "mr-brain") return mrBrain(manifest);
  if (name == "mr-angio") return mrAngiogram(manifest);
  if (name == "fog") return fog(manifest);
  if (name == "cloud") return cloud(manifest);
  if (name == "levelset") return levelSet(manifest);
  if (name == "grayscale") return grayscale(manifest);
  if (name.starts_with(kIso)) return isoSurfaces(name.substr(kIso.size()));
  if (name.starts_with(kSolidFrom)) return solidFrom(solidValue(name), manifest);
  if (isPreset(name)) return colored(name, manifest);
  throw Error(ErrorCode::kUsage, "'" + std::string(name) + "' is not a transfer function preset; there are " +
                                     presetList() + presetHint(name));
}

}  // namespace kiln
