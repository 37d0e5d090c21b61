// Problem. A compressed stream can only be read forwards, and bricks must be cut during the single pass.
// Method. A monitor with a single lock. A lane reads the next strip of rows if no lane is reading and the ring has
// room; else takes the next brick whose slices are all there; else waits. Reading has priority because reading cannot
// be divided.
// Invariant. The ring holds the slices from the first slice needed by an unfinished layer of bricks to the last slice
// read, and is at least a layer thick. So whenever the ring is full, that layer is complete, and no lane waits for
// ever.
// Cost. Constant work per strip and brick; a strip is 256 KiB, of a single slice or of several thin slices.
#pragma once

#include <condition_variable>
#include <functional>
#include <map>
#include <mutex>
#include <optional>

#include "base/progress.h"
#include "convert/stream/slice_ring.h"

namespace kiln {

class ForwardWindow {
 public:
  /// Returns the next brick (brickAt) to be cut, in rising order; nothing after the last brick.
  using Next = std::function<std::optional<std::int64_t>()>;

  /// shape: bricks of `brick_size` with their aprons. requires: the ring holds at least `slicesOfLayer`; nothing has
  /// been read from `source`, and nothing else reads from it.
  ForwardWindow(VolumeSource& source, std::unique_ptr<SliceRing> ring, std::int64_t brick_size, Next next,
                Progress& progress);

  /// Upper bound for the slices that one layer of bricks covers, aprons included.
  static std::int64_t slicesOfLayer(const Extent3& dims, std::int64_t brick_size);

  /// Joins the work until all bricks are taken: reads, and calls brick(i) for each brick of `next`; the brick's box can
  /// be copied during the call. Each brick is handled once over all calls.
  /// thread: any number of concurrent calls; one suffices. throws: the exceptions of source, ring, `next` and `brick`,
  /// Error kCancelled; all other calls then return.
  void work(const std::function<void(std::int64_t)>& brick);
  /// shape: as VolumeSource::read. requires: called by brick(i), with `box` inside its stored box. thread: safe.
  void copy(const VoxelBox& box, std::span<std::byte> out) const { ring_->copy(box, out); }
  /// True if the source was read to the end, which is needed for the last layer of bricks. requires: no call of `work`
  /// is under way; `waitedSeconds`, the total waiting time of all calls, requires the same.
  bool readAll() const { return read_to_.z == source_.info().geometry.dims.z; }
  double waitedSeconds() const { return waited_s_; }

 private:
  // Slices of a layer of bricks, aprons included.
  struct Layer {
    std::int64_t lo = 0, hi = 0;
  };
  std::int64_t layerOf(std::int64_t brick) const { return brick / bricks_in_layer_; }
  Layer slicesOf(std::int64_t layer) const;
  /// First slice needed by a brick in work or by the next brick.
  std::int64_t firstNeeded() const;
  /// First slice for which the ring has no room, or the end.
  std::int64_t readableEnd() const;
  bool mayRead() const;
  VoxelBox nextStrip() const;
  void readStrip(std::unique_lock<std::mutex>& lock);
  void cut(const std::function<void(std::int64_t)>& brick, std::unique_lock<std::mutex>& lock);
  void unlocked(std::unique_lock<std::mutex>& lock, const std::function<void()>& step);

  VolumeSource& source_;
  const std::unique_ptr<SliceRing> ring_;
  const std::int64_t brick_size_, strip_rows_, bricks_in_layer_;
  Progress& progress_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::map<std::int64_t, std::int64_t> in_work_;  // by layer: bricks taken and not finished
  const Next next_;
  std::optional<std::int64_t> next_brick_;
  VoxelCoord read_to_;  // the next row to read
  bool begun_ = false, reading_ = false, failed_ = false;
  double waited_s_ = 0;
};

}  // namespace kiln
