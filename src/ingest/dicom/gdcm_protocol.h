// A request to the worker gdcm_reader, which decodes one compressed frame (base/worker_process.h). Numbers have the
// machine's byte order.
#pragma once

#include <cstdint>

namespace kiln {

/// Precedes the sizes of the fragments, as u64, and their bytes. The answer is the stored values of the frame.
struct GdcmFrameHead {
  std::uint64_t frame_bytes;
  std::uint32_t columns, rows, fragments;
  std::uint16_t bits_allocated, bits_stored, high_bit, is_signed;
  /// A UID has at most 64 characters. Ends with a zero.
  char transfer_syntax[68];
};

}  // namespace kiln
