// Measures the work of each thread. Every piece of work, from reading a brick to drawing a tile, is a scope; scopes of
// one thread nest. A scope always adds its processor time to BusyTimes, and is also written to an active trace
// (base/thread/trace.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace kiln {

class Trace;

enum class Activity {
  kFrame,   // a whole frame
  kPlan,    // work once per frame
  kWalk,    // the octree above bricks, and the choice of the next reads
  kWait,    // waiting for a brick that is not in memory yet
  kRead,    // reading a brick's file and testing its checksum
  kDecode,  // decoding file bytes to voxels
  kBrick,   // from the first to the last tile of a brick
  kCells,   // the visible cells of a brick
  kTile,    // drawing a brick in a tile
  kFinish,  // planes, means of sub-pixels, background
  kWrite,   // writing a picture's file
};
inline constexpr std::size_t kActivities = 11;

std::string_view nameOf(Activity activity);
/// True if a scope of this activity is work. While a thread waits it does not work, and a frame's work has scopes of
/// its own.
constexpr bool works(Activity activity) {
  return activity != Activity::kFrame && activity != Activity::kWait && activity != Activity::kBrick;
}

/// Time of all threads in finished scopes, each without its inner scopes. unit: seconds of processor time, so a waiting
/// or preempted thread adds nothing.
struct BusyTimes {
  std::array<double, kActivities> seconds{};
  double of(Activity activity) const { return seconds[static_cast<std::size_t>(activity)]; }
  /// Sum over the working activities.
  double total() const;
  BusyTimes since(const BusyTimes& earlier) const;
  void add(const BusyTimes& other);
  static BusyTimes now();
};

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
