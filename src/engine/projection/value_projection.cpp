#include "engine/projection/value_projection.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <tuple>

#include "base/thread/parallel.h"
#include "traverse/tile_scope.h"

namespace kiln {
namespace {

// Returns the zones of the pixel engine, with slabs divided so that samples are at most half a voxel apart.
std::vector<SlabZone> rayZones(const Manifest& volume, const View& view, std::optional<int> level, double near_depth) {
  std::vector<SlabZone> out = slabZones({&volume, near_depth}, view, level);
  for (SlabZone& zone : out) {
    const glm::dvec3 edges = volume.levels[static_cast<std::size_t>(zone.level)].geometry.spacing();
    const double most = 0.5 * std::min({edges.x, edges.y, edges.z});
    const int parts = std::max(1, static_cast<int>(std::ceil(zone.thickness / most - 1e-9)));
    zone.thickness /= parts;
    zone.slabs *= parts;
  }
  return out;
}

bool crosses(const DepthZones::Depths& depths, const SlabZone& zone) {
  return depths.far >= zone.near && depths.near <= zone.far;
}

}  // namespace

ValueProjection::ValueProjection(const StoreReader& store, const FrameLevels& levels, const View& view,
                                 std::optional<int> level, Mode mode, bool culls)
    : store_(store),
      levels_(levels),
      mode_(mode),
      culls_(culls && mode != Mode::kAverage),
      zones_(levels, rayZones(store.manifest(), view, level, levels.projector(levels.finest()).nearDepth())) {
  for (int l = levels.finest(); l <= levels.coarsest(); ++l) {
    RayFrame frame{{}, &levels.projector(l), &levels.clipRegion(l), levels.dims(l), endOf(l)};
    std::copy_if(zones_.zones().begin(), zones_.zones().end(), std::back_inserter(frame.zones),
                 [&](const SlabZone& zone) { return zone.level == l; });
    frames_.push_back(frame);
  }
}

glm::dvec3 ValueProjection::endOf(int level) const {
  glm::dvec3 out;
  const Extent3 &finest = store_.manifest().geometry().dims, &span = levels_.span(level);
  for (int axis = 0; axis < 3; ++axis)
    out[axis] = static_cast<double>(finest[axis]) / static_cast<double>(span[axis]) - 0.5;
  return out;
}

VoxelBox ValueProjection::coreOf(const BrickKey& key) const {
  return coreBox(key.brick, store_.manifest().brick_size, levels_.dims(key.level));
}

BrickWalk::VisiblePart ValueProjection::anyPart() const {
  return [this](int level, const VoxelBox& core, const BrickEntry& entry, const BrickWalk::RectTest& test) {
    constexpr int kAll = std::numeric_limits<int>::max();
    if (entry.support.empty() || levels_.clipRegion(level).classify(core) == ClipRegion::Overlap::kOutside)
      return false;
    const DepthZones::Depths depths = zones_.depthsOf(level, core);
    const auto shown = [&](const SlabZone& zone) { return zone.level == level && crosses(depths, zone); };
    return std::any_of(zones_.zones().begin(), zones_.zones().end(), shown) && test({-kAll, -kAll, kAll, kAll});
  };
}

ProjectedValues ValueProjection::begin(const PixelRect& pixels) const {
  ProjectedValues out(mode_, pixels);
  parallelFor(static_cast<std::size_t>(pixels.height()), [&](std::size_t row) {
    const int y = pixels.y0 + static_cast<int>(row);
    for (int x = pixels.x0; x < pixels.x1; ++x) {
      const bool shown =
          std::any_of(frames_.begin(), frames_.end(), [&](const RayFrame& frame) { return hasSample(frame, x, y); });
      if (!shown) out.leaveOut(x, y);
    }
  });
  out.update(pixels);
  return out;
}

ValueRange ValueProjection::rangeOf(const BrickEntry& entry) {
  if (!entry.sub_ranges) return entry.support;
  ValueRange out;
  for (std::size_t i = 0; i < entry.sub_ranges->count(); ++i) out.include(entry.sub_ranges->at(i, entry.support));
  return out;
}

std::vector<BrickInView> ValueProjection::ordered(std::vector<BrickInView> front_to_back) const {
  if (mode_ == Mode::kAverage) return front_to_back;
  const ProjectedValues bounds(mode_, {0, 0, 1, 1});
  const auto urgency = [&](const BrickInView& brick) {
    const BrickEntry& entry = entryOf(brick);
    return std::tuple(entry.constant, bounds.bound(entry.core), bounds.bound(rangeOf(entry)));
  };
  std::stable_sort(front_to_back.begin(), front_to_back.end(),
                   [&](const BrickInView& a, const BrickInView& b) { return urgency(a) > urgency(b); });
  return front_to_back;
}

bool ValueProjection::hidden(const BrickInView& brick, const ProjectedValues& values) const {
  if (!culls_) return false;
  const BrickEntry& entry = entryOf(brick);
  const auto shows = [&](const ValueRange& range, const PixelRect& rect) {
    return !range.empty() && !rect.empty() && values.bound(range) > values.least(rect);
  };
  if (!shows(rangeOf(entry), brick.rect)) return true;
  if (!entry.sub_ranges) return false;
  const VoxelBox core = coreOf(brick.key);
  const SubRanges& ranges = *entry.sub_ranges;
  return !ranges.any([&](std::size_t i, const VoxelCoord& at) {
    const ValueRange range = ranges.at(i, entry.support);
    if (range.empty()) return false;
    const VoxelBox box = dilated(subBrickOf(core, store_.manifest().brick_size, ranges.along(), at), kGhosts);
    return shows(range, intersection(levels_.projector(brick.key.level).bounds(box), brick.rect));
  });
}

void ValueProjection::drawTile(const BrickInView& brick, const BrickBlock* block, double bound, const PixelRect& rect,
                               ProjectedValues& values, DrawCounts& counts) const {
  if (culls_ && !(bound > values.least(rect))) return;
  const RayFrame& frame = frames_[static_cast<std::size_t>(brick.key.level - levels_.finest())];
  if (block != nullptr)
    projectBrick(frame, *block, bound, !culls_, rect, values, counts);
  else
    projectConstant(frame, coreOf(brick.key), entryOf(brick).core.lo, rect, values, counts);
  values.update(rect);
}

DrawCounts ValueProjection::draw(const BrickInView& brick, const BrickBlock* block, const std::vector<PixelRect>& tiles,
                                 ProjectedValues& values) const {
  const double bound = values.bound(rangeOf(entryOf(brick)));
  std::vector<DrawCounts> counts(tiles.size());
  parallelFor(tiles.size(), [&](std::size_t i) {
    const PixelRect rect = intersection(tiles[i], brick.rect);
    if (rect.empty()) return;
    const TileScope span(brick.key, rect, counts[i]);
    drawTile(brick, block, bound, rect, values, counts[i]);
  });
  DrawCounts total;
  for (const DrawCounts& tile : counts) total.add(tile);
  return total;
}

}  // namespace kiln
