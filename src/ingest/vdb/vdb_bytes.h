// Validates the bytes of an OpenVDB file before OpenVDB reads them, and unpacks them: the format has no checksum, and
// OpenVDB trusts its input.
// Method. VdbLengths compares every length in the file with the bytes that follow and lists the packed parts. VdbBytes
// gives OpenVDB these parts as values without compression, unpacked by decompressors with their own bounds, and throws
// at the end of the file instead of returning nothing for ever.
// Invariant. No decompressor of OpenVDB gets bytes of the file, and no length exceeds the room for its values.
// Limit: damage inside a tree can give wrong values.
#pragma once

#include <cstdint>
#include <span>
#include <streambuf>
#include <vector>

#include "base/file/file.h"
#include "grid/vdb_lengths.h"

namespace kiln {

/// A file as a stream buffer for std::istream. Reading beyond the end throws Error kFormat, and so do damaged parts.
class VdbBytes : public std::streambuf {
 public:
  /// requires: `file` outlives this.
  explicit VdbBytes(const File& file) : file_(file), raw_(1 << 16) {}

  /// Gives the parts unpacked from the stream's position on. requires: the parts are those of VdbLengths, and stay
  /// unchanged until the next call.
  void setPacked(std::span<const VdbPacked> parts);

 protected:
  int_type underflow() override;
  std::streamsize xsgetn(char* to, std::streamsize count) override;
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override;
  pos_type seekpos(pos_type to, std::ios_base::openmode mode) override;

 private:
  std::uint64_t position() const;
  void dropWindow(std::uint64_t at);
  const VdbPacked* partFrom(std::uint64_t at) const;
  void unpack(const VdbPacked& part);
  void unpackValues(const VdbPacked& part, std::span<const std::byte> packed, std::span<std::byte> out) const;
  void show(std::vector<char>& window, std::size_t bytes) { setg(window.data(), window.data(), window.data() + bytes); }

  const File& file_;
  std::span<const VdbPacked> parts_;
  std::vector<char> raw_, unpacked_;
  std::vector<std::byte> packed_;
  // The window from eback() to egptr() holds the bytes of the file from begin_ to end_, or what they unpack to.
  std::uint64_t begin_ = 0, end_ = 0;
  bool is_unpacked_ = false;
};

/// Returns the walk over the lengths of `file`; its errors are kFormat. requires: `file` outlives the walk.
VdbLengths vdbLengths(const File& file);

}  // namespace kiln
