// A worker: a program that runs a library apart from Kiln, because a hostile file can crash the library, stall it, or
// make it take memory without end. Each of these ends the worker alone and becomes an error of the file. The next
// request needs a new worker: a pool drops a worker after an exception (ingest/bytes/handle_pool.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/process.h"

namespace kiln {

struct WorkerLimits {
  /// Upper bound of the worker's address space. The libraries alone take about 100 MiB of it. unit: bytes.
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;
  /// Upper bound of a request: of its processor time, and of the time without a byte of its answer. unit: seconds.
  int request_s = 60;
};

/// The place that an error of a request names.
struct WorkerPlace {
  std::filesystem::path file;
  std::string part;
};

/// thread: one at a time.
class WorkerProcess {
 public:
  /// The program gets the limits and then `arguments`. `library` names the library in errors. requires, throws: as
  /// ChildProcess.
  WorkerProcess(const std::filesystem::path& program, std::string_view library, const WorkerLimits& limits,
                const std::vector<std::string>& arguments = {});

  using Parts = std::initializer_list<std::span<const std::byte>>;
  /// Sends a request, whose payload is the parts one after another. Returns the size of the answer, which `receive`
  /// then reads. throws: Error kFormat, naming the place, if the library refuses the request, or the worker ends, is
  /// silent for too long, or exceeds its memory.
  std::uint64_t request(const WorkerPlace& place, std::uint32_t kind, const Parts& payload);
  /// Fills `answer` with the next bytes. throws: as `request`.
  void receive(const WorkerPlace& place, std::span<std::byte> answer);

 private:
  void send(const WorkerPlace& place, std::span<const std::byte> bytes);
  void waitFor(const WorkerPlace& place, short event);
  [[noreturn]] void fail(const WorkerPlace& place, const std::string& how) const;
  [[noreturn]] void failEnded(const WorkerPlace& place);

  std::string library_;
  int request_s_;
  ChildProcess child_;
};

}  // namespace kiln
