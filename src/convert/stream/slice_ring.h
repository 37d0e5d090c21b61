// The last slices of a volume that is read forwards, so that bricks with their aprons can be cut from a compressed
// stream in one pass. A ring: slice z takes the place of slice z - slices. In memory where there is room, else on the
// disk of the store, where nothing larger than a strip of rows passes through memory.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "base/file.h"
#include "ingest/source/volume_source.h"

namespace kiln {

class SliceRing {
 public:
  virtual ~SliceRing() = default;
  /// How many it holds.
  virtual std::int64_t slices() const = 0;
  /// How many whole slices one read may take, if they do not go beyond the end of the ring: several thin ones, where
  /// that costs no memory.
  virtual std::int64_t slicesAtOnce() const { return 1; }
  /// Reads whole rows of one slice, or up to slicesAtOnce() slices, from `source` into the ring. thread: one at a time;
  /// beside `copy` of other slices. throws: what the source throws; Error kNoSpace, kIo where the ring is on a disk.
  virtual void read(VolumeSource& source, const VoxelBox& rows) = 0;
  /// Copies a box of slices that are in the ring. shape: as VolumeSource::read. thread: safe. throws: Error kIo.
  virtual void copy(const VoxelBox& box, std::span<std::byte> out) const = 0;
};

/// shape: `slices` slices as long and wide as the volume's. cost: their bytes.
std::unique_ptr<SliceRing> sliceRingInMemory(const SourceInfo& info, std::int64_t slices);
/// The same in a scratch file on the disk of `directory`. requires: `disk` outlives it. cost: the bytes of a strip.
std::unique_ptr<SliceRing> sliceRingOnDisk(const SourceInfo& info, std::int64_t slices,
                                           const std::filesystem::path& directory, FileSystem& disk);

/// The rows of a strip, which is what is read and written at a time: about 256 KiB, at least one row.
std::int64_t stripRows(const SourceInfo& info);
/// unit: bytes.
std::uint64_t stripBytes(const SourceInfo& info);
std::uint64_t sliceBytes(const SourceInfo& info);

}  // namespace kiln
