#include "view/volume_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "grid/point_bounds.h"
#include "grid/slice_view.h"
#include "image/named_color.h"
#include "scene/transfer/label_styles.h"

namespace kiln {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kHistogramBins = 256;
// A page with more entries is no list to choose from.
constexpr std::size_t kMostLabelsListed = 4096;

// The manifest's bins, joined or split into kHistogramBins; a bin that spans several is shared evenly.
ordered_json histogramOf(const ValueHistogram& histogram) {
  std::vector<double> counts(kHistogramBins, 0);
  const double scale =
      static_cast<double>(kHistogramBins) / static_cast<double>(std::max<std::size_t>(histogram.counts.size(), 1));
  for (std::size_t i = 0; i < histogram.counts.size(); ++i) {
    const double lo = static_cast<double>(i) * scale, hi = lo + scale;
    for (auto bin = static_cast<std::size_t>(lo); bin < kHistogramBins && static_cast<double>(bin) < hi; ++bin) {
      const double inside = std::min(hi, static_cast<double>(bin + 1)) - std::max(lo, static_cast<double>(bin));
      counts[bin] += static_cast<double>(histogram.counts[i]) * inside / scale;
    }
  }
  ordered_json whole = ordered_json::array();
  for (const double count : counts) whole.push_back(std::llround(count));
  return {{"low", histogram.lo}, {"high", histogram.hi}, {"counts", whole}};
}

ordered_json labelsOfVolume(const Manifest& manifest) {
  ordered_json out = ordered_json::array();
  if (manifest.volume_class != VolumeClass::kLabels) return out;
  try {
    for (const LabelStyle& style : labelPalette(manifest).labels) {
      if (out.size() == kMostLabelsListed) break;
      out.push_back({{"value", style.label}, {"name", style.name}, {"color", hexText(style.color)}});
    }
  } catch (const Error&) {
    // Too many labels for a palette: the page shows none.
  }
  return out;
}

// The views of slices, by which the page turns places in a slice's picture to voxels.
ordered_json viewsOf(const VolumeGeometry& geometry) {
  ordered_json out = ordered_json::array();
  for (const SliceView& view : sliceViews(geometry)) {
    ordered_json letters = ordered_json::array();
    for (const char letter : {view.letters.left, view.letters.right, view.letters.top, view.letters.bottom}) {
      if (letter != 0) letters.push_back(std::string(1, letter));
    }
    out.push_back({{"plane", view.plane},
                   {"axis", view.across.index},
                   {"column", view.right.index},
                   {"leftwards", view.right.mirrored},
                   {"row", view.down.index},
                   {"upwards", view.from_bottom != view.down.mirrored},
                   {"letters", letters}});
  }
  return out;
}

ordered_json factsOf(const BrickedVolume& volume) {
  const Manifest& manifest = volume.manifest();
  const VolumeGeometry& geometry = manifest.geometry();
  const glm::dmat4& affine = geometry.world_from_index;
  ordered_json rows = ordered_json::array();
  for (int row = 0; row < 3; ++row) rows.push_back({affine[0][row], affine[1][row], affine[2][row], affine[3][row]});
  // JSON has no infinities; bins are between finite values.
  ValueRange range = manifest.range;
  if (!std::isfinite(range.lo)) range.lo = manifest.histogram.lo;
  if (!std::isfinite(range.hi)) range.hi = manifest.histogram.hi;
  return {{"name", volume.path().filename().string()},
          {"voxels", {geometry.dims.x, geometry.dims.y, geometry.dims.z}},
          {"type", nameOf(manifest.type)},
          {"spacing", vectorJson(geometry.spacing())},
          {"unit", geometry.unit},
          {"affine", rows},
          {"frame", wordOf(geometry.frame)},
          {"slices", viewsOf(geometry)},
          {"range", manifest.range.empty() ? ordered_json{0, 0} : ordered_json{range.lo, range.hi}},
          {"levels", manifest.levels.size()},
          {"classes", manifest.volume_class == VolumeClass::kLabels ? "labels" : "values"},
          {"labels", labelsOfVolume(manifest)},
          {"histogram", histogramOf(manifest.histogram)}};
}

}  // namespace

ordered_json vectorJson(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

ordered_json volumeFacts(const OpenedVolumes& volumes) {
  ordered_json out = ordered_json::array();
  for (const BrickedVolume* const volume : volumes.all()) out.push_back(factsOf(*volume));
  return out;
}

ordered_json worldBox(const OpenedVolumes& volumes) {
  PointBounds world;
  for (const BrickedVolume* const volume : volumes.all()) {
    for (const glm::dvec3& corner : volume->manifest().geometry().corners()) world.add(corner);
  }
  return {{"min", vectorJson(world.lo)}, {"max", vectorJson(world.hi)}};
}

}  // namespace kiln
