// What the threads of a frame do and for how long. Every piece of work, from reading a brick to drawing a tile, lives
// as long as a span; spans of one thread nest. They always count the processor's time, of which utilisation is made,
// and are written down where a trace is kept (base/thread/trace.h).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace kiln {

class Trace;

enum class Activity {
  kFrame,   // one frame, all of it
  kPlan,    // what is made once for a frame
  kWalk,    // the octree above bricks, and what is to be read next
  kWait,    // for a brick that is not in memory yet
  kRead,    // a brick's file, and its checksum
  kDecode,  // from the file's bytes to voxels
  kBrick,   // until all tiles of a brick are drawn
  kCells,   // which cells of a brick may be seen
  kTile,    // what a brick shows in a tile
  kFinish,  // planes, means of sub-pixels, background
  kWrite,   // a picture's file
};
inline constexpr std::size_t kActivities = 11;

std::string_view nameOf(Activity activity);
/// Whether a thread has something to do meanwhile: it has not while it waits for others, and what it does inside of a
/// frame has spans of its own.
constexpr bool works(Activity activity) {
  return activity != Activity::kFrame && activity != Activity::kWait && activity != Activity::kBrick;
}

/// What all threads of the process have spent in spans that have ended, without that of the spans inside of them. unit:
/// seconds of processor time, so that a thread that waits or is made to wait spends nothing.
struct BusyTimes {
  std::array<double, kActivities> seconds{};
  double of(Activity activity) const { return seconds[static_cast<std::size_t>(activity)]; }
  /// Of those that work.
  double total() const;
  BusyTimes since(const BusyTimes& earlier) const;
  void add(const BusyTimes& other);
  static BusyTimes now();
};

/// thread: belongs to the one that made it. cost: 1 to 2 microseconds, most of it to ask for the processor's time.
class ProfileScope {
 public:
  explicit ProfileScope(Activity activity) noexcept;
  ~ProfileScope();
  ProfileScope(const ProfileScope&) = delete;
  ProfileScope& operator=(const ProfileScope&) = delete;

  /// Whether anybody reads the notes.
  bool traced() const { return trace_ != nullptr; }
  /// Something that is true of the work, such as which brick it is. requires: traced.
  void note(std::string_view key, std::uint64_t value);
  void note(std::string_view key, std::string_view value);

 private:
  const Activity activity_;
  Trace* const trace_;
  ProfileScope* const around_;
  std::int64_t begin_ns_ = 0;       // of the trace's clock
  std::int64_t cpu_begin_ns_ = 0;   // of the thread's processor time
  std::int64_t cpu_inside_ns_ = 0;  // that spans inside have taken
  std::string notes_;               // as members of a JSON object
};

}  // namespace kiln
