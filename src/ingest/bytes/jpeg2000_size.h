// The size of an image in the first segment (SIZ) of a JPEG 2000 codestream. Source: ITU-T T.800, A.5.1.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace kiln {

struct Jpeg2000Size {
  std::uint64_t columns = 0, rows = 0;
  int components = 0;
  /// Bits of a sample of the first component.
  int bits = 0;
  bool is_signed = false;
  /// True if the first component has fewer samples than the image has pixels.
  bool is_subsampled = false;
};

/// Number of bytes that `jpeg2000SizeAt` reads.
inline constexpr std::size_t kJpeg2000SizeBytes = 45;

/// Returns the size if `codestream` begins as a codestream does; nothing otherwise, or if the size contradicts itself.
std::optional<Jpeg2000Size> jpeg2000SizeAt(std::span<const std::byte> codestream);

}  // namespace kiln
