// An OpenVDB file in memory, from grids whose leaves were packed beforehand. OpenVDB's own writer compresses every leaf
// twice, first to note its length for delayed loading, then to write it, and wants the values as a tree of floats; this
// one takes what was compressed once, from wherever it was, and gives the same bytes. Internal, and not installed.
#pragma once

#include <openvdb/openvdb.h>

#include <cstddef>
#include <cstdint>
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

/// The values of a grid's active voxels as its file holds them, leaf after leaf in the tree's order.
class PackedLeaves {
 public:
  /// Appends a leaf: `count` values of `value_bytes` bytes each, those of its active voxels in order of their offsets.
  /// requires: every inactive voxel of the leaf has the background's value.
  void add(const openvdb::util::NodeMask<3>& active, const void* values, std::size_t value_bytes, std::size_t count);

  /// Makes room for whole leaves that do not compress, so that nothing is moved while they are added.
  void reserve(std::size_t leaves, std::size_t value_bytes);

  std::span<const std::byte> bytes() const { return buffer_.data(); }
  /// The length of each leaf's values, with their own length in front. unit: bytes.
  std::span<const std::int64_t> lengths() const { return lengths_; }

 private:
  MemoryWriter buffer_;
  std::ostream out_{&buffer_};
  std::vector<std::int64_t> lengths_;
};

/// A grid's name, transform and topology, and its values. The values of the grid's own leaves are not read.
struct PackedGrid {
  openvdb::GridBase::Ptr grid;
  PackedLeaves leaves;
};

/// The bytes of the file, but for the random UUID in it: Blosc, active-mask compression, grid offsets.
std::vector<std::byte> archiveOf(std::span<const PackedGrid> grids, const openvdb::MetaMap& metadata);

}  // namespace kiln
