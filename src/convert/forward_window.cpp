#include "convert/forward_window.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <utility>

#include "base/elapsed.h"
#include "store/manifest.h"

namespace kiln {

std::int64_t ForwardWindow::slicesOfLayer(const Extent3& dims, std::int64_t brick_size) {
  return std::min(brick_size + 2 * kApron, dims.z);
}

ForwardWindow::ForwardWindow(VolumeSource& source, std::unique_ptr<SliceRing> ring, std::int64_t brick_size, Next next,
                             Progress& progress)
    : source_(source),
      ring_(std::move(ring)),
      strip_rows_(stripRows(source.info())),
      bricks_in_layer_(brickLattice(source.info().geometry.dims, brick_size).x *
                       brickLattice(source.info().geometry.dims, brick_size).y),
      progress_(progress),
      next_(std::move(next)) {
  const Extent3& dims = source.info().geometry.dims;
  assert(ring_->slices() >= slicesOfLayer(dims, brick_size));
  for (std::int64_t lo = 0; lo < dims.z; lo += brick_size) {
    const std::int64_t first = std::max<std::int64_t>(lo - kApron, 0);
    layers_.push_back({first, std::min(lo + brick_size + kApron, dims.z)});
  }
}

void ForwardWindow::work(const std::function<void(std::int64_t)>& brick) {
  std::unique_lock lock(mutex_);
  if (!std::exchange(begun_, true)) next_brick_ = next_();
  while (!failed_ && next_brick_) {
    if (mayRead()) {
      readStrip(lock);
    } else if (layerOf(*next_brick_).hi <= read_to_.z) {
      cut(brick, lock);
    } else {
      const auto begin = std::chrono::steady_clock::now();
      changed_.wait(lock);
      waited_s_ += secondsSince(begin);
    }
  }
}

std::int64_t ForwardWindow::firstNeeded() const {
  const auto in_work =
      std::find_if(layers_.begin(), layers_.end(), [](const Layer& layer) { return layer.bricks_in_work > 0; });
  const std::int64_t next = layerOf(*next_brick_).lo;
  return in_work == layers_.end() ? next : std::min(in_work->lo, next);
}

bool ForwardWindow::mayRead() const {
  return !reading_ && read_to_.z < std::min(firstNeeded() + ring_->slices(), source_.info().geometry.dims.z);
}

VoxelBox ForwardWindow::nextStrip() const {
  const Extent3& dims = source_.info().geometry.dims;
  return {read_to_, {dims.x, std::min(read_to_.y + strip_rows_, dims.y), read_to_.z + 1}};
}

void ForwardWindow::readStrip(std::unique_lock<std::mutex>& lock) {
  reading_ = true;
  const VoxelBox rows = nextStrip();
  unlocked(lock, [&] { ring_->read(source_, rows); });
  reading_ = false;
  read_to_.y = rows.hi.y;
  if (rows.hi.y < source_.info().geometry.dims.y) return;
  read_to_ = {0, 0, rows.hi.z};
  changed_.notify_all();
}

void ForwardWindow::cut(const std::function<void(std::int64_t)>& brick, std::unique_lock<std::mutex>& lock) {
  const std::int64_t taken = *next_brick_;
  std::int64_t& in_work = layers_[static_cast<std::size_t>(taken / bricks_in_layer_)].bricks_in_work;
  ++in_work;
  next_brick_ = next_();
  unlocked(lock, [&] { brick(taken); });
  --in_work;
  changed_.notify_all();
}

void ForwardWindow::unlocked(std::unique_lock<std::mutex>& lock, const std::function<void()>& step) {
  lock.unlock();
  try {
    progress_.throwIfCancelled("converting");
    step();
  } catch (...) {
    lock.lock();
    failed_ = true;
    changed_.notify_all();
    throw;
  }
  lock.lock();
}

}  // namespace kiln
