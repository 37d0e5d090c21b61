#include "convert/write_behind.h"

#include <utility>

namespace kiln {

WriteBehind::WriteBehind(std::size_t most, Write write) : most_(most), write_(std::move(write)) {
  if (most_ > 0) writer_ = std::thread([this] { writeAll(); });
}

WriteBehind::~WriteBehind() {
  if (!writer_.joinable()) return;
  {
    const std::scoped_lock lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  writer_.join();
}

void WriteBehind::add(UnwrittenBrick brick) {
  if (most_ == 0) return write_(brick);
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return failure_ || waiting_.size() < most_; });
  if (failure_) std::rethrow_exception(failure_);
  waiting_.push_back(std::move(brick));
  lock.unlock();
  changed_.notify_all();
}

void WriteBehind::finish() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return failure_ || waiting_.empty(); });
  if (failure_) std::rethrow_exception(failure_);
}

void WriteBehind::writeAll() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [&] { return closing_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const UnwrittenBrick& brick = waiting_.front();  // stays in place while bricks are added
    lock.unlock();
    std::exception_ptr failure;
    try {
      write_(brick);
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    waiting_.pop_front();
    if (failure) {
      failure_ = failure;
      waiting_.clear();
    }
    changed_.notify_all();
    if (failure) return;
  }
}

}  // namespace kiln
