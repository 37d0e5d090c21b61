// Writes an OpenVDB file in memory from grids whose leaves are already packed.
// Problem. OpenVDB's writer compresses every leaf twice (for the length in the delayed-loading table, then for the
// file), needs values as a tree of floats, and visits every possible tile.
// Method. Leaves are compressed once, from any memory layout; trees have no tiles.
// Invariant. The bytes equal those of OpenVDB's writer, except the UUID.
// Internal, not installed.
#pragma once

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <ostream>
#include <span>
#include <streambuf>
#include <vector>

namespace kiln {

/// A growing buffer that can be written at any position, as a file with offsets needs.
class MemoryWriter : public std::streambuf {
 public:
  std::vector<std::byte> take() { return std::move(data_); }
  std::span<const std::byte> data() const { return data_; }
  void reserve(std::size_t bytes) { data_.reserve(bytes); }

 protected:
  std::streamsize xsputn(const char* from, std::streamsize count) override;
  int_type overflow(int_type c) override;
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override;
  pos_type seekpos(pos_type position, std::ios_base::openmode) override;

 private:
  std::vector<std::byte> data_;
  std::size_t at_ = 0;
};

/// The leaves of a grid in file order, compressed.
class PackedLeaves {
 public:
  using Mask = openvdb::util::NodeMask<3>;
  struct Leaf {
    openvdb::Coord origin;
    Mask active;
  };

  /// requires: at most `most` leaves; the grid's tree has values of `value_bytes` bytes.
  PackedLeaves(std::size_t most, std::size_t value_bytes);

  /// Appends a leaf: the `count` values of its active voxels, `stored_bytes` bytes each, in order of their offsets.
  /// Inactive voxels have the background value. requires: leaves come in tree order; `stored_bytes` is at most the
  /// tree's value size.
  void add(const Leaf& leaf, const void* values, std::size_t stored_bytes, std::size_t count);

  /// Size of a value in the tree. unit: bytes.
  std::size_t valueBytes() const { return value_bytes_; }
  std::span<const Leaf> leaves() const { return leaves_; }
  /// The compressed values of all leaves, as in the file.
  std::span<const std::byte> bytes() const { return {data_.get(), size_}; }
  /// Length of each leaf's values, including the length field. unit: bytes.
  std::span<const std::int64_t> lengths() const { return lengths_; }

 private:
  void append(const void* from, std::size_t bytes);

  std::size_t value_bytes_;
  std::vector<Leaf> leaves_;
  std::unique_ptr<std::byte[]> data_;  // capacity for leaves that do not compress
  std::size_t size_ = 0;
  std::vector<std::int64_t> lengths_;
};

/// A grid without leaves (name, transform and type; background 0), and the leaves that its file will have.
struct PackedGrid {
  openvdb::GridBase::Ptr grid;
  PackedLeaves leaves;
};

/// Length of the topology at the start of `file` if it is exactly that of a tree of these leaves; else 0. unit: bytes.
/// requires: leaves in tree order.
std::size_t matchTopology(std::span<const std::byte> file, std::span<const PackedLeaves::Leaf> leaves,
                          std::size_t value_bytes, bool as_half);

/// Returns the bytes of the file, except its random UUID: Blosc, active-mask compression, grid offsets.
std::vector<std::byte> archiveOf(std::span<const PackedGrid> grids, const openvdb::MetaMap& metadata);

}  // namespace kiln
