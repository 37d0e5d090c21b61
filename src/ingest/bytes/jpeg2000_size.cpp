#include "ingest/bytes/jpeg2000_size.h"

namespace kiln {

std::optional<Jpeg2000Size> jpeg2000SizeAt(std::span<const std::byte> codestream) {
  if (codestream.size() < kJpeg2000SizeBytes) return std::nullopt;
  const auto big = [&](std::size_t at, std::size_t count) {
    std::uint64_t out = 0;
    for (const std::byte byte : codestream.subspan(at, count)) out = out << 8 | std::to_integer<std::uint64_t>(byte);
    return out;
  };
  constexpr std::uint64_t kStart = 0xff4fff51;
  const std::uint64_t right = big(8, 4), lower = big(12, 4), left = big(16, 4), upper = big(20, 4), depth = big(42, 1);
  if (big(0, 4) != kStart || right <= left || lower <= upper) return std::nullopt;
  Jpeg2000Size out;
  out.columns = right - left, out.rows = lower - upper;
  out.components = static_cast<int>(big(40, 2));
  out.bits = static_cast<int>(depth & 0x7f) + 1;
  out.is_signed = depth >= 0x80;
  out.is_subsampled = big(43, 1) != 1 || big(44, 1) != 1;
  return out;
}

}  // namespace kiln
