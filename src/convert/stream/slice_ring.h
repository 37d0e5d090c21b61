// The last slices of a forward-only volume, so that bricks with aprons can be cut from a compressed stream in a single
// pass. A ring: slice z replaces slice z - slices. The ring is in memory if there is room, else on the disk of the
// store; then at most a strip of rows passes through memory.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "base/file/file.h"
#include "ingest/source/volume_source.h"

namespace kiln {

class SliceRing {
 public:
  virtual ~SliceRing() = default;
  /// Capacity of the ring. unit: slices.
  virtual std::int64_t slices() const = 0;
  /// Upper bound for whole slices in one read, up to the end of the ring: several thin slices, if this needs no
  /// memory.
  virtual std::int64_t slicesAtOnce() const { return 1; }
  /// Reads whole rows of one slice, or up to slicesAtOnce() slices, from `source` into the ring.
  /// thread: one at a time, concurrently with `copy` of other slices. throws: the exceptions of the source; Error
  /// kNoSpace, kIo if the ring is on a disk.
  virtual void read(VolumeSource& source, const VoxelBox& rows) = 0;
  /// Copies a box of slices that are in the ring. shape: as VolumeSource::read. thread: safe. throws: Error kIo.
  virtual void copy(const VoxelBox& box, std::span<std::byte> out) const = 0;
};

/// Makes a ring in memory. shape: `slices` slices of the volume's width and height. cost: their bytes.
std::unique_ptr<SliceRing> sliceRingInMemory(const SourceInfo& info, std::int64_t slices);
/// Makes a ring in a scratch file on the disk of `directory`. requires: `disk` outlives the ring. cost: the bytes of a
/// strip.
std::unique_ptr<SliceRing> sliceRingOnDisk(const SourceInfo& info, std::int64_t slices,
                                           const std::filesystem::path& directory, FileSystem& disk);

/// Rows of a strip, the unit of reading and writing: about 256 KiB, at least one row.
std::int64_t stripRows(const SourceInfo& info);
/// unit: bytes.
std::uint64_t stripBytes(const SourceInfo& info);
std::uint64_t sliceBytes(const SourceInfo& info);

}  // namespace kiln
