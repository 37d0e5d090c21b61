// Plans the memory and the scratch files of a conversion before it begins: the slices of a stream, buffers for each
// lane, files waiting to be written, the source's cache, and the parts that coarser bricks are made of.
#pragma once

#include <optional>

#include "convert/convert.h"
#include "ingest/source/brick_order.h"

namespace kiln {

struct ConversionPlan {
  /// Memory held by the open source. unit: bytes.
  std::uint64_t source_bytes = 0;
  /// Slices of a source that can only be read forwards; 0 if any box can be read.
  std::int64_t window_slices = 0;
  bool window_on_disk = false;
  /// Memory of the window (slices, or a strip of slices) and of the decoder of the stream. unit: bytes.
  std::uint64_t window_bytes = 0;
  /// Upper bound for the scratch files beside the store until it is finished: slices, parts beyond `parts_bytes`, and
  /// sub-ranges. unit: bytes.
  std::uint64_t scratch_bytes = 0;
  std::uint64_t lane_bytes = 0;
  std::size_t lanes = 1;
  /// Bricks that may wait to be written while lanes make the next bricks; 0 if lanes write. `unwritten_bytes` is the
  /// size of the waiting bricks. unit: bytes.
  std::size_t unwritten_bricks = 0;
  std::uint64_t unwritten_bytes = 0;
  /// The order of bricks; a stream is read in the order of layers.
  std::optional<BrickOrder> order;
  /// Capacity of the source's cache of decoded data. unit: bytes.
  std::uint64_t kept_bytes = 0;
  /// Times that a block of the source is decoded, on average; 0 if the source decodes no blocks.
  double decodings = 0;
  /// Memory that suffices to decode each block once. unit: bytes.
  std::uint64_t once_bytes = 0;
  /// Memory for parts of bricks that wait for a parent (convert/pyramid/half_brick_store.h). unit: bytes.
  std::uint64_t parts_bytes = 0;
  /// The tables of all bricks: the index without sub-ranges, the state of each brick, and the table of waiting parts.
  /// unit: bytes.
  std::uint64_t index_bytes = 0;
  /// Sub-ranges of all bricks, counted as if no brick were constant; 0 if they are on disk until the store is
  /// finished. unit: bytes.
  std::uint64_t sub_ranges_bytes = 0;
  bool sub_ranges_on_disk = false;
  /// Share of the lanes' memory for pieces on their way to other ranks. unit: bytes.
  std::uint64_t given_bytes = 0;
  std::uint64_t total() const {
    return source_bytes + window_bytes + lanes * lane_bytes + unwritten_bytes + kept_bytes + parts_bytes + index_bytes +
           sub_ranges_bytes;
  }
};

/// Returns the best use of `options.memory_bytes`. Priorities:
/// 1. a lane for each thread that can be kept busy,
/// 2. slices of a stream (else on disk),
/// 3. a file per lane that waits to be written,
/// 4. sub-ranges (else on disk),
/// 5. decoded blocks, in the order of bricks that needs fewest decodings,
/// 6. parts (else on disk).
/// throws: Error kBudget, naming the smallest memory that works; it depends on the number of bricks, not on the size of
/// a slice.
ConversionPlan planConversion(const VolumeSource& source, const ConvertOptions& options);

/// Memory for the index entry and the conversion state of a brick, of any level and size. unit: bytes.
inline constexpr std::uint64_t kBrickBytes = 96;
/// Returns the number of bricks of all levels.
std::uint64_t brickCountOf(const SourceInfo& info, const ConvertOptions& options);
/// Returns the memory of the tables of bricks and of waiting parts, which cannot be on disk, with bricks in the order
/// of layers. unit: bytes.
std::uint64_t tablesBytes(const SourceInfo& info, const ConvertOptions& options);

/// throws: Error kBudget if the index of all bricks exceeds half of the machine's memory. A sparse grid of a few
/// distant voxels can span so many bricks.
void requireRoomForIndex(const SourceInfo& info, const ConvertOptions& options);

}  // namespace kiln
