// Validates the bytes of an OpenVDB file before OpenVDB reads them: the format has no checksum, and OpenVDB trusts its
// input. VdbBytes throws at the end of the file instead of returning nothing for ever. VdbLengths compares the lengths
// in names, metadata and offsets with the file.
// Limit: compressed blocks inside a tree are not checked. A file altered there on purpose can crash OpenVDB; accidental
// damage there can give wrong values.
#pragma once

#include <cstdint>
#include <streambuf>
#include <vector>

#include "base/file/file.h"
#include "grid/vdb_lengths.h"

namespace kiln {

/// A file as a stream buffer for std::istream. Reading beyond the end throws Error kFormat.
class VdbBytes : public std::streambuf {
 public:
  /// requires: `file` outlives this.
  explicit VdbBytes(const File& file) : file_(file), buffer_(1 << 16) {}

 protected:
  int_type underflow() override;
  std::streamsize xsgetn(char* to, std::streamsize count) override;
  pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override;
  pos_type seekpos(pos_type to, std::ios_base::openmode mode) override;

 private:
  std::uint64_t position() const { return next_ + static_cast<std::uint64_t>(gptr() - eback()); }
  const File& file_;
  std::vector<char> buffer_;
  std::uint64_t next_ = 0;  // file position of eback()
};

/// Returns the walk over the lengths of `file`; its errors are kFormat. requires: `file` outlives the walk.
VdbLengths vdbLengths(const File& file);

}  // namespace kiln
