// Bricks out of a source that can only be read forwards, while it is being read. A monitor: each lane, under one lock,
// takes the next strip of rows to read where nobody reads and the ring has room, else the next brick whose slices are
// all there, else waits. Reading goes first, as it is the one thing that cannot be divided.
// Invariant: the ring holds the slices from the first that an unfinished layer of bricks needs to the last one read,
// and it is at least one layer thick; so whenever it is full that layer is whole, and nobody waits in vain.
// Cost: constant work a strip and a brick; a strip is 256 KiB, of one slice or of several thin ones.
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
  /// The next brick (brickAt) to be cut, in rising order; nothing after the last.
  using Next = std::function<std::optional<std::int64_t>()>;

  /// shape: bricks of `brick_size` with their aprons. requires: the ring holds at least `slicesOfLayer`; nothing has
  /// been read from `source`, and nobody else reads from it.
  ForwardWindow(VolumeSource& source, std::unique_ptr<SliceRing> ring, std::int64_t brick_size, Next next,
                Progress& progress);

  /// The most slices that one layer of bricks covers, aprons included.
  static std::int64_t slicesOfLayer(const Extent3& dims, std::int64_t brick_size);

  /// Takes part until all bricks are taken: reads, and calls brick(i) for each that `next` gives, whose box may be
  /// copied meanwhile; each once, over all calls. thread: any number of calls at once, one suffices. throws: what
  /// source, ring, `next` and `brick` throw, Error kCancelled; all other calls then return.
  void work(const std::function<void(std::int64_t)>& brick);
  /// shape: as VolumeSource::read. requires: inside of a brick's stored box, in its turn. thread: safe.
  void copy(const VoxelBox& box, std::span<std::byte> out) const { ring_->copy(box, out); }
  /// Whether the source was read to its end, as it is by whoever takes a brick of the last layer. requires: no call of
  /// `work` is under way. So does `waitedSeconds`, how long calls of it waited for slices, together.
  bool readAll() const { return read_to_.z == source_.info().geometry.dims.z; }
  double waitedSeconds() const { return waited_s_; }

 private:
  // Slices of a layer of bricks, aprons included.
  struct Layer {
    std::int64_t lo = 0, hi = 0;
  };
  std::int64_t layerOf(std::int64_t brick) const { return brick / bricks_in_layer_; }
  Layer slicesOf(std::int64_t layer) const;
  /// The first slice that a brick in work, or the next one, needs.
  std::int64_t firstNeeded() const;
  /// The slice that there is no room for, or the end.
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
  std::map<std::int64_t, std::int64_t> in_work_;  // by layer, bricks that are taken and not finished
  const Next next_;
  std::optional<std::int64_t> next_brick_;
  VoxelCoord read_to_;  // the next row
  bool begun_ = false, reading_ = false, failed_ = false;
  double waited_s_ = 0;
};

}  // namespace kiln
