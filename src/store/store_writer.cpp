#include "store/store_writer.h"

#include <fmt/format.h>

#include <cstring>
#include <memory>

#include "base/error.h"
#include "base/memory/memory.h"
#include "store/manifest/store_files.h"
#include "store/store_reader.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

bool allEqual(std::span<const std::byte> voxels, std::size_t voxel_bytes) {
  // Bit for bit: a buffer that equals itself shifted by one voxel holds a single value.
  return std::memcmp(voxels.data(), voxels.data() + voxel_bytes, voxels.size() - voxel_bytes) == 0;
}

// `finish` syncs all bricks; the disk writes a brick while the next bricks are made. Bricks that exceed the page cache
// bypass it, because they would evict pages that other programs read.
WritePolicy brickPolicyOf(const Manifest& manifest) {
  const std::uint64_t bytes = static_cast<std::uint64_t>(manifest.geometry().dims.count()) * sizeOf(manifest.type);
  return bytes > machineMemoryBytes() / 2 ? WritePolicy::kPastCache : WritePolicy::kBegun;
}

}  // namespace

fs::path brickPath(const BrickKey& key) {
  return fmt::format("bricks/{}/{}_{}_{}.vdb", key.level, key.brick.x, key.brick.y, key.brick.z);
}

StoreWriter::StoreWriter(const fs::path& directory, Manifest draft, FileSystem& disk, bool sub_ranges_on_disk)
    : directory_(directory), manifest_(std::move(draft)), disk_(disk), brick_policy_(brickPolicyOf(manifest_)) {
  if (isStore(directory)) {
    throw Error(ErrorCode::kExists, directory, "", "is there already; name another output or give --overwrite");
  }
  manifest_.layBricks();
  for (std::size_t i = 0; i < manifest_.levels.size(); ++i)
    disk_.makeDirectories(directory_ / "bricks" / std::to_string(i));
  manifest_.container_version = containerVersion();
  index_ = BrickIndex(manifest_.lattices());
  if (sub_ranges_on_disk) sub_ranges_.emplace(disk_.makeScratch(directory_));
}

void StoreWriter::keep(const BrickKey& key, const BrickEntry& entry) {
  BrickEntry& kept = index_.at(key);
  kept = entry;
  if (!sub_ranges_ || !entry.sub_ranges) return;
  disk_.writeAt(*sub_ranges_, index_.place(key) * entry.sub_ranges->bytes().size(), entry.sub_ranges->bytes());
  kept.sub_ranges.reset();
}

BrickEntry StoreWriter::wholeEntry(const BrickKey& key) const {
  BrickEntry out = entry(key);
  if (sub_ranges_ && !out.constant) out.sub_ranges = subRangesAt(index_.place(key));
  return out;
}

std::shared_ptr<const SubRanges> StoreWriter::subRangesAt(std::size_t place) const {
  const int along = subBricksOf(manifest_.brick_size);
  std::vector<std::byte> bytes(SubRanges::bytesOf(along));
  sub_ranges_->readAt(place * bytes.size(), bytes);
  return std::make_shared<const SubRanges>(along, bytes);
}

BrickDesc StoreWriter::frame(const BrickKey& key) const { return descOf(manifest_, key); }

BrickEntry entryOf(const BrickDesc& brick, std::span<const std::byte> voxels, const BrickRanges& ranges) {
  BrickEntry entry;
  entry.core = ranges.core;
  entry.support = ranges.support;
  // Both tests are needed: a coarse brick may be uniform although `core`, which includes finer levels, is not. Such a
  // brick has a file, so that the finer values are found.
  entry.constant = !entry.core.empty() && entry.core.lo == entry.core.hi && allEqual(voxels, sizeOf(brick.type));
  if (!entry.constant)
    entry.sub_ranges =
        std::make_shared<const SubRanges>(subBricksOf(brick.brick_size), ranges.sub_bricks, entry.support);
  return entry;
}

EncodedBrick StoreWriter::encode(const BrickKey& key, std::span<const std::byte> voxels, const BrickRanges& ranges) {
  const BrickDesc brick = frame(key);
  EncodedBrick out{key, entryOf(brick, voxels, ranges), {}};
  if (!out.entry.constant) {
    out.file = encodeBrick(brick, voxels, ranges.cells);
    out.entry.file_bytes = out.file.size();
    out.entry.checksum = hashOf(out.file);
  }
  keep(key, out.entry);
  return out;
}

void StoreWriter::write(const EncodedBrick& brick) {
  if (!brick.entry.constant) disk_.writeOwn(directory_ / brickPath(brick.key), brick.file, brick_policy_);
}

ValueRange StoreWriter::range() const { return index_.valueRange(); }

void StoreWriter::countStored() {
  index_.forEachKey([&](const BrickKey& key) {
    LevelInfo& level = manifest_.levels[static_cast<std::size_t>(key.level)];
    const BrickEntry& entry = index_.at(key);
    if (!entry.constant) ++level.stored_bricks;
    level.stored_bytes += entry.file_bytes;
  });
}

std::uint64_t StoreWriter::storedBricks() const {
  std::uint64_t out = 0;
  for (const LevelInfo& level : manifest_.levels) out += level.stored_bricks;
  return out;
}

std::uint64_t StoreWriter::bytesWritten() const {
  std::uint64_t out = 0;
  for (const LevelInfo& level : manifest_.levels) out += level.stored_bytes;
  return out;
}

void StoreWriter::finish(const ValueHistogram& histogram, std::uint64_t nan_count) {
  HashStream hash;
  std::uint64_t index_bytes = 0;
  BrickIndex::SubRangesAt missing;
  if (sub_ranges_) missing = [this](std::size_t place) { return subRangesAt(place); };
  disk_.writeOwn(directory_ / kIndexFile, [&](const fs::path& next) {
    disk_.writeFile(next, {}, WritePolicy::kUnsynced);
    index_.encode(
        [&](std::span<const std::byte> piece) {
          disk_.appendFile(next, piece);
          hash.add(piece);
          index_bytes += piece.size();
        },
        missing);
  });
  // Everything that the manifest guarantees must reach the disk before the manifest.
  disk_.syncAll(directory_);
  countStored();
  manifest_.range = range();
  manifest_.index_bytes = index_bytes;
  manifest_.index_checksum = hash.value();
  manifest_.histogram = histogram;
  manifest_.nan_count = nan_count;
  disk_.writeOwn(directory_ / kManifestFile, manifestText(manifest_));
  disk_.syncAll(directory_);
}

}  // namespace kiln
