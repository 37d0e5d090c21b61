// Voxel bytes that can be read forwards only: compressed, or written as text.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace kiln {

class ByteStream {
 public:
  virtual ~ByteStream() = default;
  /// Fills `out`. throws: Error kFormat, with the byte of the file and `where` ("slice 3"), for a stream that is cut,
  /// damaged or ends too early; kIo.
  virtual void read(std::span<std::byte> out, const std::string& where) = 0;
  /// Reads to the end of the stream, so that its checksum is verified. Returns notes for the user about bytes that were
  /// not read. throws: as read.
  virtual std::vector<std::string> finish() = 0;
  /// Memory of the stream, whatever its length. unit: bytes.
  virtual std::uint64_t heldBytes() const = 0;

  /// Reads `count` bytes and drops them. throws: as read.
  void skip(std::uint64_t count, const std::string& where) {
    std::vector<std::byte> dropped(static_cast<std::size_t>(std::min<std::uint64_t>(count, kSkipBytes)));
    while (count > 0) {
      const std::size_t now = static_cast<std::size_t>(std::min<std::uint64_t>(count, dropped.size()));
      read(std::span(dropped).first(now), where);
      count -= now;
    }
  }

 protected:
  static constexpr std::size_t kSkipBytes = 1 << 16;
};

}  // namespace kiln
