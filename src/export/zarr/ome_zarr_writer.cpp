// OME-Zarr 0.5: the levels of the store from the exported one on, each an array of shards. A shard gets its name when
// it is whole, so an interrupted export goes on behind the last shard. The group's header is written last. Chunks have
// 64³ voxels, and shards at most 32 MiB of voxels: a box that small budgets hold.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <span>

#include "base/file/path_name.h"
#include "base/file/path_status.h"
#include "base/hash.h"
#include "base/thread/parallel.h"
#include "export/output/pending_folder.h"
#include "export/source/export_formats.h"
#include "export/source/output_place.h"
#include "export/zarr/blosc_pack.h"
#include "export/zarr/ome_container.h"
#include "export/zarr/ome_metadata.h"
#include "export/zarr/zarr_shard.h"
#include "grid/box_copy.h"
#include "grid/declared_look.h"
#include "store/brick_index.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::int64_t kChunkEdge = 64;
constexpr Extent3 kChunk = {kChunkEdge, kChunkEdge, kChunkEdge};

// Chunks along x, y, z of a shard. A small volume has a smaller shard.
Extent3 chunksOfShard(const ExportedVolume& volume) {
  const std::size_t bytes = sizeOf(volume.type);
  const Extent3 most = {4, bytes > 4 ? 2 : 4, bytes > 2 ? 2 : 4}, all = brickLattice(volume.geometry.dims, kChunkEdge);
  return {std::min(most.x, all.x), std::min(most.y, all.y), std::min(most.z, all.z)};
}

Extent3 shardOf(const ExportedVolume& volume) {
  const Extent3 chunks = chunksOfShard(volume);
  return {chunks.x * kChunkEdge, chunks.y * kChunkEdge, chunks.z * kChunkEdge};
}

std::uint64_t inflatedChunkBytes(VoxelType type) { return static_cast<std::uint64_t>(kChunk.count()) * sizeOf(type); }

std::vector<ExportedVolume> exportedPyramid(const ExportTarget& target, const ExportedVolume& finest) {
  std::vector<ExportedVolume> out;
  for (int level = finest.level; level < target.store.index().levels(); ++level)
    out.push_back(exportedVolume(target.store, level, target.region));
  return out;
}

// An unfinished export must have the voxels of the finished export. The look is in the header, which is written last.
std::string contentsText(const ExportTarget& target, const ExportedVolume& volume) {
  return "kiln export 3, OME-Zarr, " + identityOf(target.store, volume);
}

// Window and colours of the header; empty without both.
std::string lookText(const DeclaredLook& look) {
  if (look.empty()) return "";
  std::string out;
  if (look.ramp) out = fmt::format("{} to {} {}", look.ramp->begin, look.ramp->end, textOf(look.ramp->color));
  for (const auto& [label, color] : look.labels) out += fmt::format(" {}={}", label, textOf(color));
  return ", look " + toHex(hashOf(out));
}

// A finished export must have the header, too.
std::string finishedText(const ExportTarget& target, const ExportedVolume& volume) {
  return contentsText(target, volume) + lookText(target.store.manifest().look);
}

void requireReplaceable(const ExportTarget& target) {
  ExportInputs(target.store).requireNone(target.out);
  if (!isThere(target.out)) return;
  requireAbsent(target.out, target.overwrite);
  requireOmeContainer(target.out);
}

class OmeZarrWriter : public VolumeWriter {
 public:
  OmeZarrWriter(const ExportTarget& target, const ExportedVolume& finest, ExportNotes& notes)
      : target_(target),
        volumes_(exportedPyramid(target, finest)),
        group_text_(omeGroupText(volumes_,
                                 {nameOfImage(target.out), finishedText(target, finest), target.store.manifest().look,
                                  target.store.manifest().range},
                                 notes)),
        folder_(target.out, contentsText(target, finest) + "\n", leftoverFor(target.resume, target.overwrite),
                target.disk) {
    background_.resize(inflatedChunkBytes(finest.type));
    withVoxelType(finest.type, [&]<class T>(std::type_identity<T>) {
      const T value = static_cast<T>(finest.background);
      for (std::size_t at = 0; at < background_.size(); at += sizeof value)
        std::memcpy(&background_[at], &value, sizeof value);
    });
  }

  const std::vector<ExportedVolume>& volumes() const override { return volumes_; }
  BoxRule boxes(const ExportedVolume& volume) const override { return {BoxRule::Kind::kGrid, shardOf(volume)}; }
  std::uint64_t workBytes(std::uint64_t, unsigned threads) const override {
    const std::uint64_t chunk = inflatedChunkBytes(volumes_.front().type),
                        chunks = chunksOfShard(volumes_.front()).count();
    return chunks * packedBloscBytes(chunk) + chunk + threads * (chunk + bloscWorkBytes(chunk));
  }
  bool holds(const ExportedVolume& volume, const VoxelBox& box) override {
    if (!folder_.continued()) return false;
    const std::uint64_t bytes =
        wholeShardBytes(shardPath(volume, box), static_cast<std::size_t>(chunksOfShard(volume).count()));
    bytes_ += bytes;
    return bytes > 0;
  }
  void write(const ExportedVolume& volume, const VoxelBox& box, std::span<const std::byte> voxels) override {
    const Extent3 lattice = chunksOfShard(volume);
    std::vector<std::vector<std::byte>> chunks(static_cast<std::size_t>(lattice.count()));
    parallelFor(chunks.size(), [&](std::size_t i) {
      chunks[i] = packedChunk(volume.type, chunkAt(box, brickAt(lattice, static_cast<std::int64_t>(i))), box, voxels);
    });
    if (std::all_of(chunks.begin(), chunks.end(), [](const auto& chunk) { return chunk.empty(); })) return;
    bytes_ += writeShard(shardPath(volume, box), chunks, target_.disk);
    wrote_ = true;
  }
  std::string keepParts() override {
    if (!wrote_ && !folder_.continued()) return "";
    folder_.keep();
    return fmt::format("whole shards are kept in {}; continue with --resume", folder_.path().string());
  }
  WrittenFiles finish() override {
    for (std::size_t i = 0; i < volumes_.size(); ++i) {
      const fs::path array = arrayFolder(volumes_[i]);
      target_.disk.makeDirectories(array);
      writeText(array / kZarrHeader, zarrArrayText(volumes_[i], shardOf(volumes_[i]), kChunk));
    }
    writeText(folder_.path() / kZarrHeader, group_text_);
    requireReplaceable(target_);  // again: files may have come into the old container meanwhile
    folder_.publish();
    return {bytes_, {}};
  }

 private:
  static std::string nameOfImage(const fs::path& out) {
    const std::string name = withoutTrailingSlash(out).filename().string();
    return name.substr(0, name.find('.'));
  }
  fs::path arrayFolder(const ExportedVolume& volume) const {
    return folder_.path() / std::to_string(volume.level - volumes_.front().level);
  }
  fs::path shardPath(const ExportedVolume& volume, const VoxelBox& box) const {
    const Extent3 shard = shardOf(volume);
    const auto number = [&](int axis) { return std::to_string((box.lo[axis] - volume.box.lo[axis]) / shard[axis]); };
    return arrayFolder(volume) / "c" / number(2) / number(1) / number(0);
  }
  static VoxelBox chunkAt(const VoxelBox& shard, const BrickCoord& chunk) {
    const VoxelCoord lo = {shard.lo.x + chunk.x * kChunkEdge, shard.lo.y + chunk.y * kChunkEdge,
                           shard.lo.z + chunk.z * kChunkEdge};
    return {lo, {lo.x + kChunkEdge, lo.y + kChunkEdge, lo.z + kChunkEdge}};
  }
  // Empty for a chunk of background, which has no bytes. Voxels beyond the volume are background.
  std::vector<std::byte> packedChunk(VoxelType type, const VoxelBox& chunk, const VoxelBox& box,
                                     std::span<const std::byte> voxels) const {
    if (intersection(chunk, box).empty()) return {};
    std::vector<std::byte> numbers = background_;
    copyCommon(voxels, box, numbers, chunk, sizeOf(type));
    if (numbers == background_) return {};
    return packBlosc(numbers, sizeOf(type));
  }
  void writeText(const fs::path& path, const std::string& text) {
    target_.disk.writeOwn(path, bytesOf(text), WritePolicy::kUnsynced);
    bytes_ += text.size();
  }

  const ExportTarget target_;
  const std::vector<ExportedVolume> volumes_;
  const std::string group_text_;
  PendingFolder folder_;
  std::vector<std::byte> background_;  // a chunk of it
  std::uint64_t bytes_ = 0;
  bool wrote_ = false;
};

}  // namespace

bool isWrittenOmeZarr(const ExportTarget& target, const ExportedVolume& volume) {
  const fs::path header = target.out / kZarrHeader;
  return isThere(header) && exportedContents(readTextFile(header, kLargestOmeHeader)) == finishedText(target, volume);
}

std::unique_ptr<VolumeWriter> openOmeZarrWriter(const ExportTarget& target, const ExportedVolume& volume,
                                                ExportNotes& notes) {
  requireReplaceable(target);
  return std::make_unique<OmeZarrWriter>(target, volume, notes);
}

}  // namespace kiln
