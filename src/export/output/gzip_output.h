// A gzip stream of one member, compressed in blocks on all threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace kiln {

class GzipOutput {
 public:
  using Sink = std::function<void(std::span<const std::byte>)>;
  /// Gives the compressed bytes to `sink`, in order. The bytes do not depend on threads or on the pieces of `write`.
  /// requires: the bytes of all calls under a larger ThreadLimit than later calls have are less than a block.
  explicit GzipOutput(Sink sink);
  /// throws: as the sink; std::bad_alloc.
  void write(std::span<const std::byte> data);
  /// Ends the stream. Called once.
  void finish();
  /// Memory of a stream, with this number of threads. unit: bytes.
  static std::uint64_t bytes(unsigned threads);

 private:
  void compressHeld();

  Sink sink_;
  std::vector<std::byte> held_;
  std::size_t held_begin_ = 0;  // the bytes before are the last ones compressed, to which blocks refer
  std::uint32_t checksum_ = 0;
  std::uint64_t length_ = 0;
};

}  // namespace kiln
