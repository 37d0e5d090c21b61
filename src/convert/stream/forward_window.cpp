#include "convert/stream/forward_window.h"

#include <algorithm>
#include <cassert>
#include <chrono>
#include <utility>

#include "base/elapsed.h"
#include "store/manifest/manifest.h"

namespace kiln {

std::int64_t ForwardWindow::slicesOfLayer(const Extent3& dims, std::int64_t brick_size) {
  return std::min(brick_size + 2 * kApron, dims.z);
}

ForwardWindow::ForwardWindow(VolumeSource& source, std::unique_ptr<SliceRing> ring, std::int64_t brick_size, Next next,
                             Progress& progress)
    : source_(source),
      ring_(std::move(ring)),
      brick_size_(brick_size),
      strip_rows_(stripRows(source.info())),
      bricks_in_layer_(brickLattice(source.info().geometry.dims, brick_size).x *
                       brickLattice(source.info().geometry.dims, brick_size).y),
      progress_(progress),
      next_(std::move(next)) {
  assert(ring_->slices() >= slicesOfLayer(source.info().geometry.dims, brick_size));
}

ForwardWindow::Layer ForwardWindow::slicesOf(std::int64_t layer) const {
  const std::int64_t lo = layer * brick_size_;
  return {std::max<std::int64_t>(lo - kApron, 0), std::min(lo + brick_size_ + kApron, source_.info().geometry.dims.z)};
}

void ForwardWindow::work(const std::function<void(std::int64_t)>& brick) {
  std::unique_lock lock(mutex_);
  if (!std::exchange(begun_, true)) next_brick_ = next_();
  while (!failed_ && next_brick_) {
    if (mayRead()) {
      readStrip(lock);
    } else if (slicesOf(layerOf(*next_brick_)).hi <= read_to_.z) {
      cut(brick, lock);
    } else {
      const auto begin = std::chrono::steady_clock::now();
      changed_.wait(lock);
      waited_s_ += secondsSince(begin);
    }
  }
}

std::int64_t ForwardWindow::firstNeeded() const {
  const std::int64_t next = layerOf(*next_brick_);
  return slicesOf(in_work_.empty() ? next : std::min(in_work_.begin()->first, next)).lo;
}

std::int64_t ForwardWindow::readableEnd() const {
  return std::min(firstNeeded() + ring_->slices(), source_.info().geometry.dims.z);
}

bool ForwardWindow::mayRead() const { return !reading_ && read_to_.z < readableEnd(); }

// Returns some rows of a slice, or several whole slices that are contiguous in the ring.
VoxelBox ForwardWindow::nextStrip() const {
  const Extent3& dims = source_.info().geometry.dims;
  const std::int64_t to_wrap = ring_->slices() - read_to_.z % ring_->slices();
  const std::int64_t slices =
      read_to_.y > 0 ? 1 : std::min({ring_->slicesAtOnce(), to_wrap, readableEnd() - read_to_.z});
  return {read_to_, {dims.x, std::min(read_to_.y + strip_rows_, dims.y), read_to_.z + slices}};
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
  const auto layer = in_work_.emplace(layerOf(taken), 0).first;
  ++layer->second;
  next_brick_ = next_();
  unlocked(lock, [&] { brick(taken); });
  if (--layer->second == 0) in_work_.erase(layer);
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
