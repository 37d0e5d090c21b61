// What a conversion will hold in memory and beside its store, decided before it begins: the slices of a stream, a lane
// of buffers a thread, files that wait to be written, what the source keeps decoded, and the parts of which coarser
// bricks are made.
#pragma once

#include "convert/convert.h"

namespace kiln {

struct ConversionPlan {
  /// What the source holds as long as it is open. unit: bytes.
  std::uint64_t source_bytes = 0;
  /// Slices of a source that is only read forwards; 0 where any box can be read.
  std::int64_t window_slices = 0;
  bool window_on_disk = false;
  /// In memory: those slices or a strip of them, and what the stream needs to be decoded. unit: bytes.
  std::uint64_t window_bytes = 0;
  /// The most that is on the disk of the store until it is finished: slices, and parts beyond `parts_bytes`. unit:
  /// bytes.
  std::uint64_t scratch_bytes = 0;
  std::uint64_t lane_bytes = 0;
  std::size_t lanes = 1;
  /// Bricks that may wait to be written while lanes make the next ones; 0 where lanes write them. unit of
  /// `unwritten_bytes`: bytes, of all of them.
  std::size_t unwritten_bricks = 0;
  std::uint64_t unwritten_bytes = 0;
  /// What the source may keep of what it decoded. unit: bytes.
  std::uint64_t kept_bytes = 0;
  /// Parts of bricks that wait for a parent (convert/pyramid/half_brick_store.h), in memory. unit: bytes.
  std::uint64_t parts_bytes = 0;
  /// The tables of all bricks: the index without sub-ranges, what is done with each brick, and where parts wait. unit:
  /// bytes.
  std::uint64_t index_bytes = 0;
  /// Sub-ranges of all bricks, as if none were of one value; 0 where these are on disk until the store is finished.
  /// unit: bytes.
  std::uint64_t sub_ranges_bytes = 0;
  bool sub_ranges_on_disk = false;
  /// Within what the lanes have, pieces of bricks that may be on their way to other processes. unit: bytes.
  std::uint64_t given_bytes = 0;
  std::uint64_t total() const {
    return source_bytes + window_bytes + lanes * lane_bytes + unwritten_bytes + kept_bytes + parts_bytes + index_bytes +
           sub_ranges_bytes;
  }
};

/// The best use of `options.memory_bytes`: a lane for each thread that can be kept busy, then slices of a stream, on
/// disk where they do not fit, then a file a lane that waits to be written, then sub-ranges, on disk where they do not
/// fit, then decoded blocks, then parts, on disk where they do not fit. throws: Error kBudget, naming the smallest
/// memory that works, which depends on the number of bricks and not on the size of a slice.
ConversionPlan planConversion(const VolumeSource& source, const ConvertOptions& options);

/// What a conversion holds for each brick of any level, whatever its size: its entry of the index, and what is done
/// with it. unit: bytes.
inline constexpr std::uint64_t kBrickBytes = 96;
/// Bricks of all levels.
std::uint64_t brickCountOf(const SourceInfo& info, const ConvertOptions& options);
/// What must be in memory for each brick, and for each part that may wait, on disk or not. unit: bytes.
std::uint64_t tablesBytes(const SourceInfo& info, const ConvertOptions& options);

/// throws: Error kBudget where the index of all bricks, which is in memory, takes more than half of the machine's: a
/// few voxels that are far from each other, as a sparse grid may have them, are a volume of so many bricks.
void requireRoomForIndex(const SourceInfo& info, const ConvertOptions& options);

}  // namespace kiln
