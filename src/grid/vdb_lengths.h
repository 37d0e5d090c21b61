// Checks the lengths in an OpenVDB file before OpenVDB reads the bytes.
// Problem. The format has no checksum, and OpenVDB allocates by a length before it reads: 100 bytes can take 4 GiB.
// Method. Walks the head of the file and of each grid (names, metadata, transform) exactly as OpenVDB does, and
// compares every length with the bytes that follow. `treeMemory` also walks the nodes and leaves of a tree: a node
// takes up to 33 times its bytes in the file, and OpenVDB reads values that are not packed by their stored length.
// Invariant. A walk ends at the byte where OpenVDB's reader ends.
// Source: OpenVDB 10, Archive::readHeader, MetaMap::readMeta, GridDescriptor::read, Archive::readGrid, Transform::read,
// RootNode::readTopology, InternalNode::readTopology, LeafNode::readBuffers, readCompressedValues.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"

namespace kiln {

/// The bytes of a file on disk or in memory.
struct VdbFileBytes {
  std::filesystem::path path;  // for errors
  ErrorCode code = ErrorCode::kFormat;
  std::uint64_t size = 0;
  /// Copies the bytes from `at` on. requires: the range lies in the file.
  std::function<void(std::uint64_t at, std::span<std::byte> out)> copy;
};

/// Type of the metadata in which OpenVDB stores the lengths of a grid's leaves.
inline constexpr std::string_view kDelayedLoadType = "__delayedload";

/// A part of a file that OpenVDB would give to a decompressor.
struct VdbPacked {
  enum class Kind : std::uint8_t {
    kZip,    // values
    kBlosc,  // values
    kHint    // the value of a metadata entry of type kDelayedLoadType
  };
  /// Place of the part's length: eight bytes before values, four before a hint.
  std::uint64_t at = 0;
  /// Length of the unpacked values; 0 for a hint. unit: bytes.
  std::uint32_t bytes = 0;
  Kind kind = Kind::kZip;
};

/// Each walk starts at a byte of the file and returns the byte behind the walked part. throws: Error of
/// `VdbFileBytes::code`, with the byte offset, if a length exceeds the file or contradicts the type of a value;
/// kUnsupported for files before OpenVDB 1.0 (format versions below 218) and versions newer than the library's.
class VdbLengths {
 public:
  explicit VdbLengths(VdbFileBytes file) : file_(std::move(file)) {}

  /// Walks magic number, versions, identifier and metadata of the file, up to the number of grids. `newest` is the
  /// library's version of the format.
  std::uint64_t fileHead(std::uint32_t newest);
  /// Walks name, type and file offsets of a grid. requires: fileHead has returned.
  std::uint64_t descriptor(std::uint64_t at);
  /// Walks compression, metadata and transform of a grid, up to its tree. requires: fileHead has returned.
  std::uint64_t gridHead(std::uint64_t at);

  /// The values of a tree, as stored in the file.
  struct Values {
    std::string type;  // OpenVDB's name: "float"
    bool half = false;
    /// Compression flags of the file. From version 222 on each grid has its own flags instead.
    std::uint32_t compression = 0;
  };
  /// True if all values of this type have equal length; false for text and points.
  static bool knowsMemoryOf(const std::string& type);
  /// Returns the memory of OpenVDB's tree at `at`, nodes and voxels, with the list of its packed parts.
  /// unit: bytes. requires: gridHead returned `at`; knowsMemoryOf(values.type).
  /// throws: Error kUnsupported if the tree has several buffers, or if descriptor and metadata of the grid disagree
  /// about half precision.
  std::uint64_t treeMemory(std::uint64_t at, const Values& values);
  /// The packed parts of the last grid head, and of the tree that was walked after it. shape: ascending places.
  const std::vector<VdbPacked>& packed() const { return packed_; }
  /// True if nodes of the last walked tree have packed values, not its leaves alone. No values at all may be packed,
  /// too, and unpack to nothing.
  bool hasPackedNodes() const { return has_packed_nodes_; }

 private:
  template <class T>
  T number(std::uint64_t at) const;
  template <class T>
  T take();
  std::string text();
  void skip(std::uint64_t bytes);
  void metadata();
  void transform();
  std::uint64_t innerNode(std::uint64_t slots, const Values& values);
  void leaf(const Values& values);
  std::uint64_t bitsOf(std::uint64_t slots);
  void valuesOfNode(std::uint64_t slots, std::uint64_t children, std::uint64_t active, const Values& values);
  void valuesIn(std::uint64_t bytes, std::uint32_t compression);
  [[noreturn]] void fail(std::uint64_t at, const std::string& what) const;

  VdbFileBytes file_;
  std::uint32_t version_ = 0;
  bool has_places_ = true;  // the file holds offsets of its grids
  std::uint32_t grid_compression_ = 0;
  bool halves_ = false;  // the walked grid's values are stored with half precision
  std::uint64_t at_ = 0;
  std::uint64_t leaves_ = 0;  // of the walked tree
  std::vector<VdbPacked> packed_;
  bool has_packed_nodes_ = false;
};

}  // namespace kiln
