// Lengths inside an OpenVDB file, walked before OpenVDB reads the bytes. Problem: the format has no checksum, and
// OpenVDB allocates what a length says before reading that many bytes, so that 100 bytes can take 4 GiB. Method: walk
// the head of the file and the head of each grid (names, metadata, transform) exactly as OpenVDB reads them, and
// compare every length with the bytes that follow. Invariant: a walk ends at the byte where OpenVDB's reader ends.
// treeMemory walks the nodes of a tree, too, because a node takes up to 33 times its bytes of the file.
// Source: OpenVDB 10, Archive::readHeader, MetaMap::readMeta, DelayedLoadMetadata::readValue, GridDescriptor::read,
// Archive::readGrid, Transform::read, RootNode::readTopology, InternalNode::readTopology, readCompressedValues.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "base/error.h"

namespace kiln {

/// The bytes of a file or of a file in memory.
struct VdbFileBytes {
  std::filesystem::path path;  // for errors
  ErrorCode code = ErrorCode::kFormat;
  std::uint64_t size = 0;
  /// Copies the bytes from `at` on. requires: they are in the file.
  std::function<void(std::uint64_t at, std::span<std::byte> out)> copy;
};

/// Each walk begins at a byte of the file and returns the byte behind the part. throws: Error of the code above, with
/// the byte, where a length is more than the file holds or contradicts the type of a value; kUnsupported for files of
/// before OpenVDB 1.0 (format versions below 218), and for newer ones than the library reads.
class VdbLengths {
 public:
  explicit VdbLengths(VdbFileBytes file) : file_(std::move(file)) {}

  /// Magic number, versions, identifier and the file's metadata: up to the number of grids. `newest` is the library's
  /// own version of the format.
  std::uint64_t fileHead(std::uint32_t newest);
  /// Name, type and places of a grid. requires: fileHead has returned.
  std::uint64_t descriptor(std::uint64_t at);
  /// Compression, metadata and transform of a grid: up to its tree. requires: fileHead has returned.
  std::uint64_t gridHead(std::uint64_t at);

  /// The values of a tree, as the file has them.
  struct Values {
    std::string type;  // as OpenVDB names it: "float"
    bool half = false;
    /// The file's flags of OpenVDB's compression. Files from version 222 on give flags with each grid instead.
    std::uint32_t compression = 0;
  };
  /// Whether values of this type have one length: not text and points.
  static bool knowsMemoryOf(const std::string& type);
  /// Returns the memory that OpenVDB takes for the tree at `at`: nodes and voxels. Walks the nodes without voxels.
  /// unit: bytes. requires: gridHead returned `at`; knowsMemoryOf(values.type).
  /// throws: Error kUnsupported where the tree has several buffers.
  std::uint64_t treeMemory(std::uint64_t at, const Values& values);

 private:
  template <class T>
  T number(std::uint64_t at) const;
  template <class T>
  T take();
  std::string text();
  void skip(std::uint64_t bytes);
  void metadata();
  void delayedLoad(std::uint64_t end);
  void packedNumbers(std::uint32_t packed_bytes, std::uint64_t number_bytes, std::uint64_t count, std::uint64_t end);
  void transform();
  std::uint64_t innerNode(std::uint64_t slots, const Values& values);
  std::uint64_t bitsOf(std::uint64_t slots);
  void valuesOfNode(std::uint64_t slots, std::uint64_t children, std::uint64_t active, const Values& values);
  [[noreturn]] void fail(std::uint64_t at, const std::string& what) const;

  VdbFileBytes file_;
  std::uint32_t version_ = 0;
  bool has_places_ = true;  // of grids in the file
  std::uint32_t grid_compression_ = 0;
  std::uint64_t at_ = 0;
};

}  // namespace kiln
