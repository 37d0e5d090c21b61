// Memory that OpenEXR needs to compress a picture: two blocks of rows per thread, each in several copies. Measured with
// OpenEXR 3.1, which has no interface for this number.
#pragma once

#include <cstdint>
#include <string>

namespace kiln {

/// The picture's properties that decide the memory. shape: `width` pixels (deep images: samples) in each of `height`
/// rows.
struct ExrShape {
  std::int64_t width = 0, height = 0;
  bool exr_float = false;         // type of the colours: float, else half
  std::uint64_t plane_bytes = 0;  // per pixel, all channels except the colours
  std::string compression = "zip";
};

/// Number of OpenEXR's own threads (0, or at least 2), and rows converted at a time.
struct ExrWork {
  int threads = 0;
  int rows = 1;
};

/// Work for so many threads, and its memory. unit of exrBytes: bytes.
ExrWork exrWork(const ExrShape& shape, int threads);
std::uint64_t exrBytes(const ExrShape& shape, const ExrWork& work);

/// Work for the threads in force, or for fewer threads if these need more than `memory_bytes`. One thread is used even
/// if its memory exceeds the limit.
ExrWork exrWorkWithin(const ExrShape& shape, std::uint64_t memory_bytes);

}  // namespace kiln
