// A file of what each thread did when, for people to look at: Chrome's trace format, which Perfetto and
// chrome://tracing draw, one track a thread. Source: "Trace Event Format" of the Chromium project. Spans that have
// ended wait as text in a buffer of fixed size and are added to the file whenever it is full, so that a trace of any
// length takes the same memory.
#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "base/temporary_file.h"
#include "base/thread/profile_scope.h"

namespace kiln {

/// A span that has ended. unit: nanoseconds since the trace began; `busy_ns` of processor time.
struct TracedScope {
  Activity activity;
  std::int64_t begin_ns, end_ns, busy_ns;
};

class Trace {
 public:
  /// What it holds at the most, whatever is written. unit: bytes.
  static constexpr std::size_t kMemoryBytes = std::size_t{1} << 20;

  /// From here on, spans are written to a temporary name beside `path`. One trace is kept at a time. throws: Error kIo,
  /// kNoSpace, kNotFound.
  explicit Trace(const std::filesystem::path& path);
  /// Without `finish` nothing is left of it; after a failed write nothing is left at once, so that the disk has room.
  /// requires: no span has a begin and no end.
  ~Trace();
  Trace(const Trace&) = delete;
  Trace& operator=(const Trace&) = delete;

  /// Writes the rest and gives the file its name. throws: Error kIo, kNoSpace, of this or of what was written before.
  void finish();

  /// The one that is kept, or null.
  static Trace* active() noexcept;
  std::int64_t nowNs() const noexcept;
  /// `notes` are members of a JSON object, each after a comma. thread: safe. A failure is kept for `finish`.
  void add(const TracedScope& span, std::string_view notes) noexcept;

  /// What the calling thread is, from now on in every trace; else it is one of those that draw. requires: a literal.
  static void nameThread(const char* name) noexcept;

 private:
  int trackOfThread();
  void put(std::string_view event);
  void flush();

  const std::filesystem::path path_;
  std::unique_ptr<const TemporaryFile> temporary_;  // none for a device, which is written to directly
  const std::chrono::steady_clock::time_point begin_;
  const std::uint64_t number_;  // of the traces of this process
  std::mutex mutex_;            // guards what follows
  std::string waiting_;
  int tracks_ = 0;
  std::exception_ptr failure_;
};

}  // namespace kiln
