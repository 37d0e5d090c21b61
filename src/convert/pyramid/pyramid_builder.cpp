#include "convert/pyramid/pyramid_builder.h"

#include <algorithm>
#include <cstring>

#include "convert/pyramid/brick_shares.h"
#include "convert/stream/half_source.h"
#include "grid/box_copy.h"
#include "grid/pyramid.h"

namespace kiln {
namespace {

// Calls f(brick) for each brick of a box of bricks.
template <class F>
void forEachBrick(const VoxelBox& bricks, F&& f) {
  forEachCoord(bricks, [&](const VoxelCoord& at) { f(brickOf(at, 1)); });
}

}  // namespace

PyramidBuilder::PyramidBuilder(StoreWriter& writer, const std::filesystem::path& parts, std::uint64_t parts_bytes,
                               FileSystem& disk, bool half, PyramidShare share)
    : writer_(writer), parts_(parts, parts_bytes, disk), half_(half), share_(std::move(share)) {
  const std::vector<LevelInfo>& levels = writer.manifest().levels;
  levels_.resize(levels.size());
  for (std::size_t l = 0; l < levels.size(); ++l) levels_[l].by = halvingOf(levels[l].geometry);
  for (std::size_t l = 0; l < levels.size(); ++l) {
    const auto count = static_cast<std::size_t>(levels[l].bricks.count());
    levels_[l].awaited.resize(l == 0 ? 0 : count);
    levels_[l].built.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      const BrickKey key{static_cast<int>(l), brickAt(levels[l].bricks, static_cast<std::int64_t>(i))};
      if (l > 0) levels_[l].awaited[i] = static_cast<std::uint16_t>(childrenOf(key).count());
    }
  }
}

std::size_t PyramidBuilder::place(const BrickKey& key) const { return placeOf(lattice(key.level), key.brick); }

VoxelBox PyramidBuilder::parentsOf(const BrickKey& key) const {
  const VoxelBox part = coarseBox(writer_.frame(key).core(), levels_[static_cast<std::size_t>(key.level)].by);
  const VoxelBox reached =
      intersection(dilated(part, writer_.manifest().apron),
                   boxOf(writer_.manifest().levels[static_cast<std::size_t>(key.level) + 1].geometry.dims));
  return coarseBox(reached, writer_.manifest().brick_size);
}

VoxelBox PyramidBuilder::childrenOf(const BrickKey& key) const {
  const VoxelBox stored = writer_.frame(key).stored();
  const Extent3& by = levels_[static_cast<std::size_t>(key.level) - 1].by;
  const Extent3& dims = writer_.manifest().levels[static_cast<std::size_t>(key.level) - 1].geometry.dims;
  const VoxelBox fine = intersection({{stored.lo.x * by.x, stored.lo.y * by.y, stored.lo.z * by.z},
                                      {stored.hi.x * by.x, stored.hi.y * by.y, stored.hi.z * by.z}},
                                     boxOf(dims));
  return coarseBox(fine, writer_.manifest().brick_size);
}

// A constant brick needs no part: its index entry has its value.
bool PyramidBuilder::keepsPart(const BrickKey& key) const { return hasNext(key.level) && !writer_.entry(key).constant; }

HalfBrick PyramidBuilder::partOf(const BrickKey& key, std::span<const std::byte> voxels, const VoxelBox& box,
                                 const BrickRanges& ranges) const {
  return coarsePartOf(writer_.frame(key), voxels, box, ranges, levels_[static_cast<std::size_t>(key.level)].by,
                      coarseOf(writer_.manifest().volume_class));
}

int PyramidBuilder::ownerOf(const BrickKey& key) const {
  return kiln::ownerOf(place(key), lattice(key.level).count(), share_.ranks);
}

std::uint64_t PyramidBuilder::ownBricks() const {
  std::uint64_t out = 0;
  for (int level = 1; level < static_cast<int>(levels_.size()); ++level) {
    for (std::int64_t i = 0; i < lattice(level).count(); ++i) out += owns({level, brickAt(lattice(level), i)}) ? 1 : 0;
  }
  return out;
}

std::map<int, VoxelBox> PyramidBuilder::takenOf(const BrickKey& key) const {
  std::map<int, VoxelBox> out;
  forEachBrick(parentsOf(key), [&](const BrickCoord& brick) {
    const BrickKey parent{key.level + 1, brick};
    const VoxelBox taken = writer_.frame(parent).stored();
    const auto [box, is_first] = out.emplace(ownerOf(parent), taken);
    if (!is_first) box->second = bounding(box->second, taken);
  });
  return out;
}

std::vector<BrickKey> PyramidBuilder::add(const BrickKey& key, std::span<const std::byte> voxels, const VoxelBox& box,
                                          const BrickRanges& ranges) {
  if (!hasNext(key.level)) return {};
  std::optional<HalfBrick> part;
  if (keepsPart(key)) part = partOf(key, voxels, box, ranges);
  for (const auto& [rank, taken] : takenOf(key)) {
    if (rank == share_.rank) continue;
    if (part) {
      const HalfBrick piece = cropped(*part, taken);
      share_.give(rank, key, &piece);
    } else {
      share_.give(rank, key, nullptr);
    }
  }
  if (part) leave(key, *std::move(part));
  return arrived(key);
}

std::vector<BrickKey> PyramidBuilder::addGiven(const BrickKey& key, const BrickEntry& entry,
                                               std::optional<HalfBrick> piece) {
  writer_.keep(key, entry);
  if (piece) leave(key, *std::move(piece));
  return arrived(key);
}

std::vector<BrickKey> PyramidBuilder::arrived(const BrickKey& key) {
  std::vector<BrickKey> ready;
  if (!hasNext(key.level)) return ready;
  const VoxelBox parents = parentsOf(key);
  const std::scoped_lock lock(mutex_);
  forEachBrick(parents, [&](const BrickCoord& brick) {
    const BrickKey parent{key.level + 1, brick};
    if (owns(parent) && --levels_[static_cast<std::size_t>(parent.level)].awaited[place(parent)] == 0)
      ready.push_back(parent);
  });
  return ready;
}

std::vector<BrickKey> PyramidBuilder::waitingFor(const BrickKey& key) const {
  std::vector<BrickKey> out;
  forEachBrick(parentsOf(key), [&](const BrickCoord& brick) {
    const BrickKey parent{key.level + 1, brick};
    if (owns(parent) && !levels_[static_cast<std::size_t>(parent.level)].built[place(parent)]) out.push_back(parent);
  });
  return out;
}

void PyramidBuilder::leave(const BrickKey& key, HalfBrick part) {
  std::vector<HalfBrickPiece> pieces;
  std::optional<BrickKey> whole;
  for (const BrickKey& parent : waitingFor(key)) {
    const VoxelBox taken = writer_.frame(parent).stored();
    if (intersection(part.box, taken) == part.box && !whole)
      whole = parent;
    else
      pieces.push_back({parent, cropped(part, taken)});
  }
  if (whole) pieces.push_back({*whole, std::move(part)});
  parts_.put(key, std::move(pieces));
}

void PyramidBuilder::gather(const BrickKey& child, const BrickKey& key, std::vector<std::byte>& voxels,
                            BrickRanges& below) {
  const BrickDesc frame = writer_.frame(key), fine = writer_.frame(child);
  const BrickEntry& entry = writer_.entry(child);
  const Extent3& by = levels_[static_cast<std::size_t>(child.level)].by;
  const HalfBrick part = entry.constant ? constantPartOf(fine, entry.core.lo, by) : parts_.take(child, key);
  copyCommon(part.voxels, part.box, voxels, frame.stored(), sizeOf(frame.type));
  if (intersection(part.box, frame.core()).empty()) return;  // a child in the apron only adds no ranges
  below.support.include(part.support);
  for (const ValueRange& cell : part.cells) below.core.include(cell);
  includeCells(part.cells, part.cell_box, below.cells, cellCubeOf(frame));
}

PyramidBuilder::Built PyramidBuilder::build(const BrickKey& key) {
  const BrickDesc frame = writer_.frame(key);
  const VoxelBox box = frame.stored();
  std::vector<std::byte> voxels(static_cast<std::size_t>(box.count()) * sizeOf(frame.type));
  BrickRanges below;
  below.cells.resize(static_cast<std::size_t>(cellCubeOf(frame).count()));
  forEachBrick(childrenOf(key), [&](const BrickCoord& brick) { gather({key.level - 1, brick}, key, voxels, below); });
  if (half_) {
    const double error = roundToHalf(frame.type, voxels).largest_error;
    const std::scoped_lock lock(mutex_);
    largest_error_ = std::max(largest_error_, error);
  }
  BrickRanges ranges = rangesOf(frame, voxels);
  for (std::size_t i = 0; i < ranges.cells.size(); ++i) ranges.cells[i].include(below.cells[i]);
  ranges.core.include(below.core);
  ranges.support.include(below.support);
  Built built;
  built.brick = writer_.encode(key, voxels, ranges);
  built.ready = add(key, voxels, box, ranges);
  return built;
}

double PyramidBuilder::largestError() const {
  const std::scoped_lock lock(mutex_);
  return largest_error_;
}

std::vector<BrickKey> PyramidBuilder::resume(const std::function<bool(const BrickKey&)>& finished,
                                             const std::function<void(const BrickKey&)>& again) {
  std::vector<BrickKey> ready;
  for (int level = 0; level < static_cast<int>(levels_.size()); ++level) {
    for (std::int64_t i = 0; i < lattice(level).count(); ++i) {
      const BrickKey key{level, brickAt(lattice(level), i)};
      if (!finished(key)) continue;
      levels_[static_cast<std::size_t>(level)].built[place(key)] = 1;
      for (const BrickKey& parent : arrived(key)) {
        if (!finished(parent)) ready.push_back(parent);
      }
    }
  }
  for (int level = 0; hasNext(level); ++level) {
    for (std::int64_t i = 0; i < lattice(level).count(); ++i) {
      const BrickKey key{level, brickAt(lattice(level), i)};
      if (finished(key) && keepsPart(key) && !waitingFor(key).empty()) again(key);
    }
  }
  return ready;
}

void PyramidBuilder::addFinished(const BrickKey& key, std::span<const std::byte> voxels, const VoxelBox& box,
                                 const BrickRanges& ranges) {
  leave(key, partOf(key, voxels, box, ranges));
}

}  // namespace kiln
