// An array of any number of axes that is stored in chunks of equal shape: of Zarr, N5 or HDF5.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "ingest/bytes/block_cache.h"
#include "ingest/chunks/stored_number.h"

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
  /// The reason why no voxel has the declared fill value, which matters once a chunk is missing; empty if one has it.
  std::string fill_fault;
};

/// The number of chunks along each axis.
AxisNumbers gridOf(const ChunkLayout& layout);

class ChunkedArray {
 public:
  virtual ~ChunkedArray() = default;
  virtual const ChunkLayout& layout() const = 0;
  /// Returns the voxels of a chunk in its stored order, in the machine's byte order; no bytes for a chunk that does not
  /// exist and holds the fill value. shape: a whole chunk, also at the border of the array. `index` counts chunks along
  /// each axis.
  /// thread: any. throws: Error kFormat (damaged, with the file), kIo, kNotFound if the whole array has gone.
  virtual std::shared_ptr<const BlockCache::Bytes> chunk(const AxisNumbers& index) = 0;
  /// Capacity for decoded chunks. unit: bytes.
  virtual void setCapacity(std::uint64_t bytes) = 0;
  /// Memory of one decoding, with the decoded chunk. unit: bytes.
  virtual std::uint64_t decodeBytes() const = 0;
  /// Memory for tables. unit: bytes.
  virtual std::uint64_t heldBytes() const = 0;
  /// Chunks that were decoded, each time counted, and the chunks among them that did not exist.
  virtual std::uint64_t decoded() const = 0;
  virtual std::uint64_t absent() const = 0;
};

}  // namespace kiln
