// Bricks out of a source that can only be read forwards, while it is being read. A monitor: each lane, under one lock,
// takes the next strip of rows to read where nobody reads and the ring has room, else the next brick whose slices are
// all there, else waits. Reading goes first, as it is the one thing that cannot be divided.
// Invariant: the ring holds the slices from the first that an unfinished layer of bricks needs to the last one read,
// and it is at least one layer thick; so whenever it is full that layer is whole, and nobody waits in vain.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <vector>

#include "base/progress.h"
#include "convert/slice_ring.h"

namespace kiln {

class ForwardWindow {
 public:
  /// shape: bricks of `brick_size` with their aprons. requires: the ring holds at least `slicesOfLayer`; nothing has
  /// been read from `source`, and nobody else reads from it.
  ForwardWindow(VolumeSource& source, std::unique_ptr<SliceRing> ring, std::int64_t brick_size, Progress& progress);

  /// The most slices that one layer of bricks covers, aprons included.
  static std::int64_t slicesOfLayer(const Extent3& dims, std::int64_t brick_size);

  /// Takes part until all bricks are taken: reads, and calls brick(i) for the i-th brick of the lattice (brickAt),
  /// whose box may be copied meanwhile; each brick once, over all calls. thread: any number of calls at once, one
  /// suffices. throws: what source, ring and `brick` throw, Error kCancelled; all other calls then return.
  void work(const std::function<void(std::int64_t)>& brick);
  /// shape: as VolumeSource::read. requires: inside of a brick's stored box, in its turn. thread: safe.
  void copy(const VoxelBox& box, std::span<std::byte> out) const { ring_->copy(box, out); }

 private:
  struct Layer {
    std::int64_t lo = 0, hi = 0;  // slices
    std::int64_t bricks_left = 0;
  };
  bool mayRead() const;
  bool ready(std::int64_t brick) const;
  VoxelBox nextStrip() const;
  void readStrip(std::unique_lock<std::mutex>& lock);
  void cut(const std::function<void(std::int64_t)>& brick, std::unique_lock<std::mutex>& lock);
  void unlocked(std::unique_lock<std::mutex>& lock, const std::function<void()>& step);

  VolumeSource& source_;
  const std::unique_ptr<SliceRing> ring_;
  const std::int64_t strip_rows_, bricks_in_layer_;
  Progress& progress_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::vector<Layer> layers_;
  std::size_t first_unfinished_ = 0;  // of layers_
  std::int64_t next_brick_ = 0;
  VoxelCoord read_to_;  // the next row
  bool reading_ = false, failed_ = false;
};

}  // namespace kiln
