// Measures the work of each thread. Every piece of work, from reading a brick to drawing a tile, is a scope; scopes of
// one thread nest. A scope always adds its processor time to BusyTimes, and is also written to an active trace
// (base/thread/trace.h).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/thread/busy_times.h"

namespace kiln {

class Trace;

/// A scope begins with construction and ends with destruction. thread: belongs to the constructing thread. cost: 1 to 2
/// microseconds, mostly to read the processor time.
class ProfileScope {
 public:
  explicit ProfileScope(Activity activity) noexcept;
  ~ProfileScope();
  ProfileScope(const ProfileScope&) = delete;
  ProfileScope& operator=(const ProfileScope&) = delete;

  /// True if a trace stores the notes.
  bool traced() const { return trace_ != nullptr; }
  /// Adds a property of the work to the trace, such as the brick. requires: traced.
  void note(std::string_view key, std::uint64_t value);
  void note(std::string_view key, std::string_view value);

 private:
  const Activity activity_;
  Trace* const trace_;
  ProfileScope* const around_;
  std::int64_t begin_ns_ = 0;       // on the clock of the trace
  std::int64_t cpu_begin_ns_ = 0;   // processor time of the thread at the start
  std::int64_t cpu_inside_ns_ = 0;  // processor time of finished inner scopes
  std::string notes_;               // members of a JSON object
};

}  // namespace kiln
