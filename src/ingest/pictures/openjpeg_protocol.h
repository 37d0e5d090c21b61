// A request to the worker openjpeg_reader, which decodes one file of JPEG 2000 (base/worker_process.h). Numbers have
// the machine's byte order.
#pragma once

#include <cstdint>

namespace kiln {

/// Precedes the bytes of the file. The answer is the values, x fastest, of 1 or 2 bytes each.
struct Jpeg2000Head {
  std::uint32_t columns, rows, bits, is_signed;
  /// 1 for a codestream in the boxes of JP2, 0 for a codestream alone.
  std::uint32_t has_boxes, padding;
};

}  // namespace kiln
