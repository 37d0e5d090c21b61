// An array of any number of axes that is stored in chunks of equal shape: of Zarr, N5 or HDF5.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ingest/bytes/block_cache.h"
#include "ingest/chunks/stored_number.h"
#include "ingest/source/brick_order.h"

namespace kiln {

/// Lengths or indices along the axes of an array, the slowest axis first.
using AxisNumbers = std::vector<std::int64_t>;

/// The number of voxels or chunks in a box of these lengths. requires: the product fits.
std::uint64_t productOf(const AxisNumbers& lengths);
/// The place of `index` in a grid, the last axis fastest.
std::int64_t placeIn(const AxisNumbers& grid, const AxisNumbers& index);

struct ChunkLayout {
  StoredNumber number;
  AxisNumbers shape;
  AxisNumbers chunk_shape;
  /// The array's axis at each place of a chunk's stored order, the slowest first.
  std::vector<int> stored_axes;
  /// The value of chunks that do not exist, as a voxel; the first bytes count.
  std::array<std::byte, 8> fill{};
  /// The reason why no voxel can hold the declared fill value; an error once a chunk is missing. Empty for legal
  /// values.
  std::string fill_fault;
};

/// The number of chunks along each axis.
AxisNumbers gridOf(const ChunkLayout& layout);

class ChunkedArray {
 public:
  explicit ChunkedArray(const ChunkLayout& layout) : grid_(gridOf(layout)) {}
  virtual ~ChunkedArray() = default;
  ChunkedArray(const ChunkedArray&) = delete;
  ChunkedArray& operator=(const ChunkedArray&) = delete;

  virtual const ChunkLayout& layout() const = 0;
  /// Returns the voxels of a chunk in its stored order, in the machine's byte order, decoded or from the cache; no
  /// bytes for a chunk that does not exist and holds the fill value. shape: a whole chunk, also at the border of the
  /// array. `index` counts chunks along each axis; `use` is the chunk's box in the volume. thread: any. throws: Error
  /// kFormat (damaged, with the file), kIo, kNotFound if the whole array has gone.
  std::shared_ptr<const BlockCache::Bytes> chunk(const AxisNumbers& index, const BlockCache::Use& use);
  /// Capacity for decoded chunks. unit: bytes.
  void setCapacity(std::uint64_t bytes) { cache_.setCapacity(bytes); }
  void setOrder(const BrickOrder& order) { cache_.setOrder(order); }
  std::uint64_t decodings() const { return cache_.decodings(); }
  /// True if chunks were read and none of them exists.
  bool isAllAbsent() const { return decodings() > 0 && absent_ == decodings(); }
  /// Memory of one decoding, with the decoded chunk. unit: bytes.
  virtual std::uint64_t decodeBytes() const = 0;
  /// Memory for tables. unit: bytes.
  virtual std::uint64_t heldBytes() const = 0;

 protected:
  /// Returns and throws as `chunk`. `place` is the chunk's place in the grid, `spare` memory for the voxels.
  virtual BlockCache::Bytes decode(const AxisNumbers& index, std::int64_t place, BlockCache::Bytes spare) = 0;

 private:
  AxisNumbers grid_;
  BlockCache cache_;
  std::atomic<std::uint64_t> absent_ = 0;
};

}  // namespace kiln
