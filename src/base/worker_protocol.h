// Messages between Kiln and a worker, which is a program that runs one library apart from Kiln (base/worker_process.h,
// base/worker_loop.h). Numbers have the machine's byte order.
#pragma once

#include <cstdint>

namespace kiln {

/// Precedes the payload of a request.
struct WorkerRequestHead {
  std::uint32_t kind;
  std::uint32_t padding;
  std::uint64_t payload_bytes;
};

/// Precedes the bytes of an answer. A refused request is answered by a sentence.
struct WorkerAnswerHead {
  std::uint64_t ok;
  std::uint64_t bytes;
};

}  // namespace kiln
