#include "convert/forward_window.h"

#include <algorithm>
#include <cassert>

#include "store/manifest.h"

namespace kiln {

std::int64_t ForwardWindow::slicesOfLayer(const Extent3& dims, std::int64_t brick_size) {
  return std::min(brick_size + 2 * kApron, dims.z);
}

ForwardWindow::ForwardWindow(VolumeSource& source, std::unique_ptr<SliceRing> ring, std::int64_t brick_size,
                             Progress& progress)
    : source_(source),
      ring_(std::move(ring)),
      strip_rows_(stripRows(source.info())),
      bricks_in_layer_(brickLattice(source.info().geometry.dims, brick_size).x *
                       brickLattice(source.info().geometry.dims, brick_size).y),
      progress_(progress) {
  const Extent3& dims = source.info().geometry.dims;
  assert(ring_->slices() >= slicesOfLayer(dims, brick_size));
  for (std::int64_t lo = 0; lo < dims.z; lo += brick_size) {
    const std::int64_t first = std::max<std::int64_t>(lo - kApron, 0);
    layers_.push_back({first, std::min(lo + brick_size + kApron, dims.z), bricks_in_layer_});
  }
}

void ForwardWindow::work(const std::function<void(std::int64_t)>& brick) {
  const std::int64_t bricks = bricks_in_layer_ * static_cast<std::int64_t>(layers_.size());
  std::unique_lock lock(mutex_);
  while (!failed_ && next_brick_ < bricks) {
    if (mayRead()) {
      readStrip(lock);
    } else if (ready(next_brick_)) {
      cut(brick, lock);
    } else {
      changed_.wait(lock);
    }
  }
}

bool ForwardWindow::mayRead() const {
  if (reading_ || first_unfinished_ == layers_.size()) return false;
  return read_to_.z < std::min(layers_[first_unfinished_].lo + ring_->slices(), source_.info().geometry.dims.z);
}

bool ForwardWindow::ready(std::int64_t brick) const {
  return layers_[static_cast<std::size_t>(brick / bricks_in_layer_)].hi <= read_to_.z;
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
  const std::int64_t taken = next_brick_++;
  unlocked(lock, [&] { brick(taken); });
  --layers_[static_cast<std::size_t>(taken / bricks_in_layer_)].bricks_left;
  while (first_unfinished_ < layers_.size() && layers_[first_unfinished_].bricks_left == 0) ++first_unfinished_;
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
