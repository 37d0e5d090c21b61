#include "companion/accompanied_volume.h"

#include <algorithm>
#include <utility>

#include "base/thread/parallel.h"
#include "base/thread/profile_scope.h"
#include "store/brick_index.h"
#include "store/codec/brick_codec.h"

namespace kiln {
namespace {

// Voxels beside a box whose companion values the samples in the box may need.
constexpr std::int64_t kSampleReach = kSubBrickReach;

// Returns the sub-ranges without the sub-bricks for which `hidden(at)` holds: the same object if none is hidden, null
// if all are hidden.
template <class Hidden>
std::shared_ptr<const SubRanges> withoutHidden(const std::shared_ptr<const SubRanges>& ranges, const Hidden& hidden) {
  SubRanges shown = *ranges;
  std::size_t cleared = 0;
  ranges->any([&](std::size_t i, const VoxelCoord& at) {
    if (hidden(at)) shown.clear(i), ++cleared;
    return false;
  });
  if (cleared == 0) return ranges;
  return cleared == ranges->count() ? nullptr : std::make_shared<const SubRanges>(std::move(shown));
}

BrickEntry maskedEntry() {
  BrickEntry out;
  out.constant = true;
  out.masked = true;
  return out;
}

// Empties the ranges of cells without shown voxels.
void hideCells(BrickBlock& block) {
  if (block.shown.all()) return;
  const auto cellAt = [&](int x, int y, int z) {
    const VoxelCoord lo = {block.core.lo.x + x * kCellSize, block.core.lo.y + y * kCellSize,
                           block.core.lo.z + z * kCellSize};
    return VoxelBox{lo, {lo.x + kCellSize, lo.y + kCellSize, lo.z + kCellSize}};
  };
  const int edge = block.supports.edge();
  for (int z = 0; z < edge; ++z) {
    for (int y = 0; y < edge; ++y) {
      for (int x = 0; x < edge; ++x) {
        const VoxelBox support = intersection(dilated(cellAt(x - 1, y - 1, z - 1), 1), block.extent);
        if (!block.shown.any(support)) block.supports.hide(x, y, z);
      }
    }
  }
  const int cells = block.octree.edge(0);
  std::vector<ValueRange> ranges(block.octree.cells().begin(), block.octree.cells().end());
  for (int z = 0; z < cells; ++z) {
    for (int y = 0; y < cells; ++y) {
      for (int x = 0; x < cells; ++x) {
        if (!block.shown.any(intersection(cellAt(x, y, z), block.core)))
          ranges[static_cast<std::size_t>((z * cells + y) * cells + x)] = {};
      }
    }
  }
  block.octree = MinMaxOctree(std::move(ranges), cells);
}

}  // namespace

AccompaniedVolume::AccompaniedVolume(std::unique_ptr<BrickedVolume> volume,
                                     std::vector<std::unique_ptr<Companion>> companions)
    : BrickedVolume(volume->path()),
      volume_(std::move(volume)),
      companions_(std::make_shared<const std::vector<std::unique_ptr<Companion>>>(std::move(companions))) {
  BrickIndex index = volume_->index();
  std::vector<BrickKey> keys;
  index.forEachKey([&](const BrickKey& key) { keys.push_back(key); });
  parallelFor(keys.size(), [&](std::size_t i) { index.at(keys[i]) = shownEntry(keys[i]); });
  hold(volume_->manifest(), std::move(index));
}

bool AccompaniedVolume::hides(int level, const VoxelBox& box) const {
  const VoxelBox stored = intersection(box, boxOf(volume_->level(level).geometry.dims));
  return !stored.empty() && std::any_of(companions_->begin(), companions_->end(),
                                        [&](const auto& companion) { return companion->hides(level, stored); });
}

BrickEntry AccompaniedVolume::shownEntry(const BrickKey& key) const {
  BrickEntry out = volume_->index().at(key);
  const BrickDesc brick = volume_->frame(key);
  if (hides(key.level, dilated(brick.core(), kSampleReach))) return maskedEntry();
  // A constant brick has no voxels; its companions' values may still differ.
  out.constant = false;
  if (!out.sub_ranges) return out;
  const int along = out.sub_ranges->along();
  out.sub_ranges = withoutHidden(out.sub_ranges, [&](const VoxelCoord& at) {
    const VoxelBox box = subBrickOf(brick.core(), brick.brick_size, along, at);
    return box.empty() || hides(key.level, dilated(box, kSampleReach));
  });
  return out.sub_ranges ? out : maskedEntry();
}

BrickBlock AccompaniedVolume::read(const BrickKey& key) const {
  const BrickDesc brick = frame(key);
  BrickBlock found;
  found.key = key;
  found.core = brick.core();
  found.extent = dilated(found.core, brick.apron);
  bool shows = !index().at(key).masked;
  for (const auto& companion : *companions_) shows = shows && companion->addTo(found);
  BrickBlock out = shows ? volume_->read(key) : constantBrick(brick, 0);
  if (!shows) found.shown = ShownVoxels(found.extent);
  out.shown = std::move(found.shown);
  out.color_values = std::move(found.color_values);
  out.companion_reads = found.companion_reads, out.companion_bytes = found.companion_bytes;
  out.masked = !shows;
  out.constant = volume_->index().at(key).constant;
  const ProfileScope span(Activity::kDecode);
  hideCells(out);
  return out;
}

std::size_t AccompaniedVolume::readBytes(const BrickKey& key) const {
  const BrickDesc brick = frame(key);
  const VoxelBox extent = dilated(brick.core(), brick.apron);
  std::size_t added = 0, work = 0;
  for (const auto& companion : *companions_) {
    added += companion->addedBytes(extent);
    work = std::max<std::size_t>(work, companion->workBytes(key.level, extent));
  }
  return added + std::max(volume_->readBytes(key), work);
}

std::size_t AccompaniedVolume::blockBytes(const BrickKey& key) const {
  const BrickDesc brick = frame(key);
  std::size_t out = volume_->blockBytes(key);
  for (const auto& companion : *companions_) out += companion->addedBytes(dilated(brick.core(), brick.apron));
  return out;
}

std::uint64_t AccompaniedVolume::heldBytes() const {
  std::uint64_t out = volume_->heldBytes() + index().bytes();
  for (const auto& companion : *companions_) out += companion->heldBytes();
  return out;
}

std::unique_ptr<BrickedVolume> AccompaniedVolume::share() const { return std::make_unique<AccompaniedVolume>(*this); }

}  // namespace kiln
