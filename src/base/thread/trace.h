// Writes a timeline of all threads to a file, one track per thread, for viewers such as Perfetto and chrome://tracing.
// Method. Finished scopes are stored as text in a buffer of fixed size, which is appended to the file when full: memory
// does not depend on the length of a trace.
// Source: "Trace Event Format" of the Chromium project.
#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "base/file/temporary_file.h"
#include "base/thread/profile_scope.h"

namespace kiln {

/// A finished scope. unit: nanoseconds since the start of the trace; `busy_ns` of processor time.
struct TracedScope {
  Activity activity;
  std::int64_t begin_ns, end_ns, busy_ns;
};

class Trace {
 public:
  /// Upper bound of the memory of a trace. unit: bytes.
  static constexpr std::size_t kMemoryBytes = std::size_t{1} << 20;

  /// Starts writing scopes to a temporary name beside `path`. At most one trace is active at a time. throws: Error kIo,
  /// kNoSpace, kNotFound.
  explicit Trace(const std::filesystem::path& path);
  /// Removes the file unless `finish` was called. After a failed write the file is removed at once, to free the disk.
  /// requires: no scope is open.
  ~Trace();
  Trace(const Trace&) = delete;
  Trace& operator=(const Trace&) = delete;

  /// Writes the rest and gives the file its name. throws: Error kIo, kNoSpace, of this or an earlier write.
  void finish();

  /// The active trace, or null.
  static Trace* active() noexcept;
  std::int64_t nowNs() const noexcept;
  /// Adds a scope. `notes` are members of a JSON object, each after a comma. thread: safe. A failure is stored for
  /// `finish`.
  void add(const TracedScope& span, std::string_view notes) noexcept;

  /// Names the calling thread in all traces from now on; an unnamed thread counts as a drawing thread. requires: a
  /// literal.
  static void nameThread(const char* name) noexcept;

 private:
  int trackOfThread();
  void put(std::string_view event);
  void flush();

  const std::filesystem::path path_;
  std::unique_ptr<const TemporaryFile> temporary_;  // none for a device, which is written directly
  const std::chrono::steady_clock::time_point begin_;
  const std::uint64_t number_;  // counts the traces of this process
  std::mutex mutex_;            // guards the members below
  std::string waiting_;
  int tracks_ = 0;
  std::exception_ptr failure_;
};

}  // namespace kiln
