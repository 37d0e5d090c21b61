// The loop of a worker's program: limits, requests on standard input, answers on standard output (base/worker_process.h
// is the other end). Linked into workers, not into Kiln.
#pragma once

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>

namespace kiln {

/// The limits of a worker, from its first two arguments.
struct WorkerArguments {
  std::uint64_t memory_bytes = 0;
  int request_s = 0;
  /// The first of the other arguments; null if there is none.
  const char* next = nullptr;
};

/// Reads the limits, and limits the memory of the process. Exits with code 2 if the arguments are no limits.
WorkerArguments startWorker(int count, char** arguments);

/// A request that is refused in a sentence.
struct WorkerRefusal : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Returns the answer to a request. May throw: the text of the exception becomes the text of the error.
using WorkerAnswer = std::function<std::string(std::uint32_t kind, const std::string& payload)>;

/// Answers requests until Kiln closes the input, then ends the process. Each request has its limit of processor time.
[[noreturn]] void serveRequests(const WorkerArguments& limits, const WorkerAnswer& answer);

}  // namespace kiln
