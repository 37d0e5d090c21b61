// Processor times of a program's threads by kind of work, as summed by scopes (base/thread/profile_scope.h).
#pragma once

#include <array>
#include <cstddef>
#include <string_view>

namespace kiln {

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

}  // namespace kiln
