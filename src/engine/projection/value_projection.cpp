#include "engine/projection/value_projection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <utility>

#include "base/thread/parallel.h"
#include "traverse/tile_scope.h"

namespace kiln {
namespace {

// Returns the zones of the pixel engine, with slabs divided so that they are at most half a voxel thick.
std::vector<SlabZone> rayZones(const Manifest& volume, const View& view, const ProjectionOptions& options,
                               double near_depth) {
  ZonedVolume zoned{&volume, near_depth};
  zoned.coarser = options.coarser;
  std::vector<SlabZone> out = slabZones(zoned, view, options.level);
  for (SlabZone& zone : out) {
    const glm::dvec3 edges = volume.levels[static_cast<std::size_t>(zone.level)].geometry.spacing();
    const double most = 0.5 * std::min({edges.x, edges.y, edges.z});
    // Zones are far deeper than a volume that is smaller than a pixel.
    constexpr int kMostSamples = 1 << 30;
    const int parts = static_cast<int>(
        std::clamp(std::ceil(zone.thickness / most - 1e-9), 1.0, static_cast<double>(kMostSamples / zone.slabs)));
    zone.thickness /= parts;
    zone.slabs *= parts;
  }
  return out;
}

// The zones of a level among all zones.
std::vector<RayZone> zonesOf(int level, const std::vector<SlabZone>& zones) {
  std::vector<RayZone> out;
  for (std::size_t i = 0; i < zones.size(); ++i) {
    if (zones[i].level != level) continue;
    RayZone zone{zones[i]};
    if (i > 0) zone.before = zones[i - 1].far - 0.5 * zones[i - 1].thickness;
    if (i + 1 < zones.size()) zone.after = zones[i + 1].near + 0.5 * zones[i + 1].thickness;
    out.push_back(zone);
  }
  return out;
}

// Adjacent zones are one span.
std::vector<DepthSpan> depthsOf(const std::vector<RayZone>& zones) {
  std::vector<DepthSpan> out;
  for (const RayZone& zone : zones) {
    if (!out.empty() && out.back().far == zone.near)
      out.back().far = zone.far;
    else
      out.push_back({zone.near, zone.far});
  }
  return out;
}

// Reach beyond a brick's voxels that the walk tests. unit: voxels.
constexpr std::int64_t kGhosts = 1;

bool crosses(const DepthZones::Depths& depths, const SlabZone& zone) {
  return depths.far >= zone.near && depths.near <= zone.far;
}

}  // namespace

struct ValueProjection::Prepared final : PreparedBrick {
  Prepared(BrickToDraw the_due, double the_bound) : due(std::move(the_due)), bound(the_bound) {}
  const BrickToDraw due;
  const double bound;  // greatest value that its samples may hold (ProjectedValues::bound)
};

ValueProjection::ValueProjection(const BrickedVolume& store, const FrameLevels& levels, const View& view,
                                 const ProjectionOptions& options)
    : store_(store),
      levels_(levels),
      held_(options.held),
      culls_(options.culls && options.held != PixelValue::kMean),
      attenuation_(options.attenuation),
      zones_(levels, rayZones(store.manifest(), view, options, levels.projector(levels.finest()).nearDepth())),
      outline_(levels.projector(levels.finest()), levels.clipRegion(levels.finest()), endOf(levels.finest())) {
  for (int l = levels.finest(); l <= levels.coarsest(); ++l) {
    RayFrame frame{
        &outline_, zonesOf(l, zones_.zones()), {}, &levels.projector(l), &levels.clipRegion(l), levels.dims(l),
        endOf(l)};
    frame.depths = depthsOf(frame.zones);
    frames_.push_back(std::move(frame));
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

BrickSelection ValueProjection::selection() const {
  const auto visible_part = [this](int level, const VoxelBox& core, const BrickEntry& entry, const RectTest& test) {
    constexpr int kAll = std::numeric_limits<int>::max();
    if (entry.support.empty() || levels_.clipRegion(level).classify(core) == ClipRegion::Overlap::kOutside)
      return false;
    const DepthZones::Depths depths = zones_.depthsOf(level, core);
    const auto shown = [&](const SlabZone& zone) { return zone.level == level && crosses(depths, zone); };
    return std::any_of(zones_.zones().begin(), zones_.zones().end(), shown) && test({-kAll, -kAll, kAll, kAll});
  };
  return {zones_.levelChoice(), visible_part, kGhosts};
}

std::unique_ptr<const PreparedBrick> ValueProjection::prepare(const BrickToDraw& brick) const {
  return std::make_unique<Prepared>(brick, values_->bound(rangeOf(store_.index().at(brick.brick.key))));
}

void ValueProjection::begin(const PixelRect& pixels) {
  ProjectedValues& out = values_.emplace(held_, pixels, attenuation_);
  if (out.mean()) return;  // a pixel without samples has no length
  parallelFor(static_cast<std::size_t>(pixels.height()), [&](std::size_t row) {
    const int y = pixels.y0 + static_cast<int>(row);
    const Silhouette::Row outline = outline_.row(y);
    for (int x = pixels.x0; x < pixels.x1; ++x) {
      const Silhouette::Part covered = outline.at(x);
      const bool shown = covered.share > 0 && std::any_of(frames_.begin(), frames_.end(), [&](const RayFrame& frame) {
                           return hasValue(frame, held_, covered.middle);
                         });
      if (!shown) out.leaveOut(x, y);
    }
  });
  out.update(pixels);
}

ValueRange ValueProjection::rangeOf(const BrickEntry& entry) {
  if (!entry.sub_ranges) return entry.support;
  ValueRange out;
  for (std::size_t i = 0; i < entry.sub_ranges->count(); ++i) out.include(entry.sub_ranges->at(i, entry.support));
  return out;
}

std::vector<BrickInView> ValueProjection::ordered(std::vector<BrickInView> front_to_back) const {
  if (takesInOrder(held_)) return front_to_back;
  const ProjectedValues bounds(held_, {0, 0, 1, 1});
  const auto urgency = [&](const BrickInView& brick) {
    const BrickEntry& entry = entryOf(brick);
    return std::tuple(entry.constant, bounds.bound(entry.core), bounds.bound(rangeOf(entry)));
  };
  std::stable_sort(front_to_back.begin(), front_to_back.end(),
                   [&](const BrickInView& a, const BrickInView& b) { return urgency(a) > urgency(b); });
  return front_to_back;
}

bool ValueProjection::hidden(const BrickInView& brick) const {
  if (!culls_) return false;
  if (values_->attenuated()) return values_->closed(brick.rect);
  const BrickEntry& entry = entryOf(brick);
  const auto shows = [&](const ValueRange& range, const PixelRect& rect) {
    return !range.empty() && !rect.empty() && values_->bound(range) > values_->least(rect);
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

void ValueProjection::drawBrick(const Prepared& brick, const PixelRect& rect, DrawCounts& counts) {
  if (culls_ && (values_->attenuated() ? values_->closed(rect) : !(brick.bound > values_->least(rect)))) return;
  const BrickKey& key = brick.due.brick.key;
  const RayFrame& frame = frames_[static_cast<std::size_t>(key.level - levels_.finest())];
  if (brick.due.block != nullptr)
    projectBrick(frame, *brick.due.block, brick.bound, !culls_, rect, *values_, counts);
  else
    projectConstant(frame, coreOf(key), store_.index().at(key).core.lo, rect, *values_, counts);
  values_->update(rect);
}

void ValueProjection::draw(std::span<const PreparedBrick* const> bricks, const TileTarget& target) {
  for (std::size_t i = 0; i < bricks.size(); ++i) {
    const auto& brick = static_cast<const Prepared&>(*bricks[i]);
    const PixelRect rect = intersection(target.pixels.rect, brick.due.rect);
    if (rect.empty()) continue;
    const TileScope span(brick.due.brick.key, rect, target.counts[i]);
    drawBrick(brick, rect, target.counts[i]);
  }
}

void ValueProjection::finish(const TransferFunction& transfer_function, const TilePixels& target) {
  parallelFor(static_cast<std::size_t>(target.rect.height()), [&](std::size_t row) {
    const int y = target.rect.y0 + static_cast<int>(row);
    const Silhouette::Row outline = outline_.row(y);
    for (int x = target.rect.x0; x < target.rect.x1; ++x) {
      const double value = values_->value(x, y);
      if (std::isnan(value)) continue;
      const double alpha = outline.at(x).share;
      const glm::dvec3 color = alpha * transfer_function.at(value).color;
      const std::ptrdiff_t place = target.placeOf(x, y);
      float* const pixel = target.rgba + 4 * place;
      for (int channel = 0; channel < 3; ++channel) pixel[channel] = static_cast<float>(color[channel]);
      pixel[3] = static_cast<float>(alpha);
      if (target.aovs.value != nullptr) target.aovs.value[place] = static_cast<float>(value);
    }
  });
  values_.reset();
}

}  // namespace kiln
