// What OpenEXR holds in memory while it compresses a picture: two blocks of rows for each of its threads, each several
// times. Known by measuring OpenEXR 3.1; it says nothing of this itself.
#pragma once

#include <cstdint>
#include <string>

namespace kiln {

/// What decides it. shape: `width` pixels, of deep images samples, in each of `height` rows.
struct ExrShape {
  std::int64_t width = 0, height = 0;
  bool exr_float = false;         // colours; else half
  std::uint64_t plane_bytes = 0;  // of a pixel, of all channels beside the colours
  std::string compression = "zip";
};

/// How a picture is written: OpenEXR's own threads, 0 or at least 2, and rows that are converted at a time.
struct ExrWork {
  int threads = 0;
  int rows = 1;
};

/// The work of so many threads, and what it takes. unit of the second: bytes.
ExrWork exrWork(const ExrShape& shape, int threads);
std::uint64_t exrBytes(const ExrShape& shape, const ExrWork& work);

/// The work of as many threads as are in force, or of fewer where that takes more than `memory_bytes`. One thread is
/// the least, whatever it takes.
ExrWork exrWorkWithin(const ExrShape& shape, std::uint64_t memory_bytes);

}  // namespace kiln
