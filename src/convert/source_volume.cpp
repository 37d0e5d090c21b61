#include "convert/source_volume.h"

#include <fmt/format.h>

#include <mutex>
#include <utility>

#include "base/error.h"
#include "base/memory/memory.h"
#include "base/thread/parallel.h"
#include "base/thread/profile_scope.h"
#include "convert/manifest_draft.h"
#include "convert/stream/value_counter.h"
#include "grid/box_copy.h"
#include "grid/pyramid.h"
#include "store/brick_index.h"
#include "store/codec/dense_brick.h"
#include "store/store_writer.h"

namespace kiln {
namespace {

Manifest emptyManifest(const SourceInfo& info, const ArrayOptions& options) {
  ConvertOptions conversion;
  conversion.brick_size = options.brick_size;
  conversion.labels = options.labels;
  requireBricks(info, conversion);
  Manifest out = draftOf(info, conversion);
  out.layBricks();
  return out;
}

// Memory of the levels from 1 on.
std::uint64_t coarseBytes(const Manifest& manifest) {
  std::uint64_t out = 0;
  for (std::size_t l = 1; l < manifest.levels.size(); ++l)
    out += CoarseLevel::bytesOf(manifest.levels[l].geometry.dims, manifest.type);
  return out;
}

void requireMemory(const Manifest& manifest, std::uint64_t memory_bytes) {
  std::uint64_t bricks = 0;
  for (const Extent3& lattice : manifest.lattices()) bricks += static_cast<std::uint64_t>(lattice.count());
  const std::uint64_t needed = BrickIndex::bytesOf(bricks, 0, manifest.brick_size) + coarseBytes(manifest);
  if (needed <= memory_bytes) return;
  throw Error(ErrorCode::kBudget, kArrayName, "memory",
              fmt::format("coarser levels and index take {} (allowed: {}); give {} or more", formatBytes(needed),
                          formatBytes(memory_bytes), roundedUpBytes(needed)));
}

// Returns the stored voxels of a brick. `levels` holds the levels from 1 on.
UnsetBytes storedVoxels(const BrickDesc& brick, VolumeSource& source, const std::vector<CoarseLevel>& levels) {
  const VoxelBox box = brick.stored();
  UnsetBytes out(static_cast<std::size_t>(box.count()) * sizeOf(brick.type));
  if (brick.key.level == 0) {
    source.read(box, out);
  } else {
    const CoarseLevel& level = levels[static_cast<std::size_t>(brick.key.level) - 1];
    copyCommon(level.voxels, level.box, out, box, sizeOf(brick.type));
  }
  return out;
}

// Makes index and coarser levels, level by level: a level is complete before its bricks are visited.
class VolumeBuild {
 public:
  VolumeBuild(VolumeSource& source, Manifest manifest, BrickIndex index, Progress& progress)
      : source_(source), manifest_(std::move(manifest)), index_(std::move(index)), progress_(progress) {}

  void run() {
    for (std::size_t l = 1; l < manifest_.levels.size(); ++l) {
      levels_.emplace_back(manifest_.levels[l].geometry.dims, manifest_.type);
      supports_.emplace_back(static_cast<std::size_t>(manifest_.levels[l].bricks.count()));
    }
    const ValueCounter none(manifest_.type, manifest_.volume_class == VolumeClass::kLabels);
    counters_.assign(ThreadLimit::active(), none);
    for (int level = 0; level < index_.levels(); ++level) visitLevel(level);
    for (std::size_t lane = 1; lane < counters_.size(); ++lane) counters_[0].add(counters_[lane].take());
    finishManifest();
  }

  Manifest takeManifest() { return std::move(manifest_); }
  BrickIndex takeIndex() { return std::move(index_); }
  std::vector<CoarseLevel> takeLevels() { return std::move(levels_); }

 private:
  bool hasNext(int level) const { return level + 1 < index_.levels(); }

  void visitLevel(int level) {
    const Extent3& lattice = index_.lattice(level);
    parallelInLanes(counters_.size(), static_cast<std::size_t>(lattice.count()), [&](std::size_t lane, std::size_t i) {
      progress_.throwIfCancelled("opening an array");
      visit({level, brickAt(lattice, static_cast<std::int64_t>(i))}, counters_[lane]);
    });
  }

  void visit(const BrickKey& key, ValueCounter& counter) {
    const BrickDesc brick = descOf(manifest_, key);
    const UnsetBytes voxels = storedVoxels(brick, source_, levels_);
    if (key.level == 0) counter.count(voxels, brick.stored(), brick.core());
    BrickRanges ranges = rangesOf(brick, voxels);
    if (key.level > 0) includeFiner(brick, ranges);
    BrickEntry entry = entryOf(brick, voxels, ranges);
    if (!entry.constant) entry.checksum = hashOf(voxels);
    if (hasNext(key.level)) leavePart(brick, voxels, ranges, entry);
    index_.at(key) = std::move(entry);
    const std::scoped_lock lock(mutex_);
    progress_.advance("opening", "bricks", ++visited_, index_.size());
  }

  // Adds the ranges of finer levels, and keeps the sums for `read`.
  void includeFiner(const BrickDesc& brick, BrickRanges& ranges) {
    const std::size_t finer = static_cast<std::size_t>(brick.key.level) - 1;
    CoarseLevel& level = levels_[finer];
    forEachCoord(cellsOf(brick.core()), [&, cube = cellCubeOf(brick)](const VoxelCoord& cell) {
      ValueRange &in_level = level.cells[offsetIn(level.cell_box, cell)],
                 &in_brick = ranges.cells[offsetIn(cube, cell)];
      ranges.core.include(in_level);
      in_level.include(in_brick);
      in_brick = in_level;
    });
    ranges.support.include(supports_[finer][placeOf(index_.lattice(brick.key.level), brick.key.brick)]);
  }

  void leavePart(const BrickDesc& brick, std::span<const std::byte> voxels, const BrickRanges& ranges,
                 const BrickEntry& entry) {
    const auto next = static_cast<std::size_t>(brick.key.level);
    const Extent3 by = halvingOf(manifest_.levels[next].geometry);
    const HalfBrick part =
        entry.constant ? constantPartOf(brick, entry.core.lo, by)
                       : coarsePartOf(brick, voxels, brick.stored(), ranges, by, coarseOf(manifest_.volume_class));
    CoarseLevel& level = levels_[next];
    copyCommon(part.voxels, part.box, level.voxels, level.box, sizeOf(manifest_.type));
    const BrickCoord parent = brickOf(part.box.lo, manifest_.brick_size);
    const std::scoped_lock lock(mutex_);  // small bricks share a cell
    supports_[next][placeOf(index_.lattice(brick.key.level + 1), parent)].include(part.support);
    includeCells(part.cells, part.cell_box, level.cells, level.cell_box);
  }

  void finishManifest() {
    manifest_.range = index_.valueRange();
    manifest_.histogram = histogramOf(manifest_, counters_[0], manifest_.range);
    manifest_.nan_count = counters_[0].nanCount();
    HashStream hash;
    index_.encode([&](std::span<const std::byte> piece) { hash.add(piece); });
    manifest_.index_checksum = hash.value();
  }

  VolumeSource& source_;
  Manifest manifest_;
  BrickIndex index_;
  Progress& progress_;
  std::vector<CoarseLevel> levels_;                // from level 1 on
  std::vector<std::vector<ValueRange>> supports_;  // by level from 1 on, by brick: values interpolated at finer levels
  std::vector<ValueCounter> counters_;             // by lane
  std::mutex mutex_;                               // guards cells and supports of the next level, and the count
  std::uint64_t visited_ = 0;
};

}  // namespace

CoarseLevel::CoarseLevel(const Extent3& dims, VoxelType type)
    : box(boxOf(dims)),
      voxels(static_cast<std::size_t>(dims.count()) * sizeOf(type)),
      cell_box(cellsOf(box)),
      cells(static_cast<std::size_t>(cell_box.count())) {}

std::uint64_t CoarseLevel::bytesOf(const Extent3& dims, VoxelType type) {
  return static_cast<std::uint64_t>(dims.count()) * sizeOf(type) +
         static_cast<std::uint64_t>(cellsOf(boxOf(dims)).count()) * sizeof(ValueRange);
}

SourceVolume::SourceVolume(std::unique_ptr<VolumeSource> source, const ArrayOptions& options, Progress& progress)
    : BrickedVolume(kArrayName), source_(std::move(source)) {
  Manifest manifest = emptyManifest(source_->info(), options);
  requireMemory(manifest, options.memory_bytes);
  BrickIndex index(manifest.lattices());
  VolumeBuild build(*source_, std::move(manifest), std::move(index), progress);
  build.run();
  coarse_ = std::make_shared<const std::vector<CoarseLevel>>(build.takeLevels());
  hold(build.takeManifest(), build.takeIndex());
}

BrickBlock SourceVolume::read(const BrickKey& key) const {
  const ProfileScope span(Activity::kRead);
  const BrickDesc brick = frame(key);
  const BrickEntry& entry = index().at(key);
  if (entry.constant) return constantBrick(brick, entry.core.lo);
  if (key.level == 0) {
    const UnsetBytes voxels = storedVoxels(brick, *source_, *coarse_);
    const int edge = static_cast<int>(brick.brick_size / kCellSize);
    return denseBrick(brick, voxels, brick.stored(),
                      cellRanges(voxels, brick.type, brick.stored(), brick.core(), edge));
  }
  const CoarseLevel& level = (*coarse_)[static_cast<std::size_t>(key.level) - 1];
  const VoxelBox cube = cellCubeOf(brick);
  std::vector<ValueRange> cells(static_cast<std::size_t>(cube.count()));
  includeCells(level.cells, level.cell_box, cells, cube);
  return denseBrick(brick, level.voxels, level.box, std::move(cells));
}

std::size_t SourceVolume::readBytes(const BrickKey& key) const { return denseBytes(frame(key)); }

std::uint64_t SourceVolume::heldBytes() const { return index().bytes() + coarseBytes(manifest()); }

std::unique_ptr<BrickedVolume> SourceVolume::share() const { return std::make_unique<SourceVolume>(*this); }

std::unique_ptr<BrickedVolume> openArray(const VoxelArray& array, const ArrayOptions& options, Progress& progress) {
  return std::make_unique<SourceVolume>(arraySource(array), options, progress);
}

}  // namespace kiln
