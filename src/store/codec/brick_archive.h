// An OpenVDB file in memory, from grids whose leaves were packed beforehand. OpenVDB's own writer compresses every leaf
// twice, first to note its length for delayed loading, then to write it, wants the values as a tree of floats, and
// looks at every tile that a tree might have; this one takes what was compressed once, from wherever it was, knows that
// there are no tiles, and gives the same bytes. Internal, and not installed.
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

/// A growing buffer that can be written at any place, as a file with offsets needs.
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

/// A grid's leaves as its file holds them, one after the other.
class PackedLeaves {
 public:
  using Mask = openvdb::util::NodeMask<3>;
  struct Leaf {
    openvdb::Coord origin;
    Mask active;
  };

  /// For at most `most` leaves of a grid whose tree has values of `value_bytes` bytes.
  PackedLeaves(std::size_t most, std::size_t value_bytes);

  /// Appends a leaf: `count` values of `stored_bytes` bytes each, those of its active voxels in order of their offsets;
  /// all others have the background's value. requires: leaves come in the order of a tree; `stored_bytes` no more than
  /// the tree's values have.
  void add(const Leaf& leaf, const void* values, std::size_t stored_bytes, std::size_t count);

  /// Of the tree's values. unit: bytes.
  std::size_t valueBytes() const { return value_bytes_; }
  std::span<const Leaf> leaves() const { return leaves_; }
  /// Their values in the file.
  std::span<const std::byte> bytes() const { return {data_.get(), size_}; }
  /// The length of each leaf's values, with their own length in front. unit: bytes.
  std::span<const std::int64_t> lengths() const { return lengths_; }

 private:
  void append(const void* from, std::size_t bytes);

  std::size_t value_bytes_;
  std::vector<Leaf> leaves_;
  std::unique_ptr<std::byte[]> data_;  // as large as leaves that do not compress
  std::size_t size_ = 0;
  std::vector<std::int64_t> lengths_;
};

/// A grid without leaves, for its name, transform and kind, and those that its file is to have. Its background is 0.
struct PackedGrid {
  openvdb::GridBase::Ptr grid;
  PackedLeaves leaves;
};

/// How many bytes of `file` are the topology of a tree of such leaves and nothing else; 0 where it begins otherwise.
/// requires: the order of a tree.
std::size_t matchTopology(std::span<const std::byte> file, std::span<const PackedLeaves::Leaf> leaves,
                          std::size_t value_bytes, bool as_half);

/// The bytes of the file, but for the random UUID in it: Blosc, active-mask compression, grid offsets.
std::vector<std::byte> archiveOf(std::span<const PackedGrid> grids, const openvdb::MetaMap& metadata);

}  // namespace kiln
