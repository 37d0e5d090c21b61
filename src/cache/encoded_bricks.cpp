#include "cache/encoded_bricks.h"

namespace kiln {

BrickFile EncodedBricks::get(const StoreReader& store, const StoredBrick& brick, bool likely) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return !being_read_.contains(brick); });
  if (const auto place = places_.find(brick); place != places_.end()) {
    recency_.splice(recency_.begin(), recency_, place->second);
    return {place->second->second, false};
  }
  being_read_.insert(brick);
  lock.unlock();
  Bytes bytes;
  std::exception_ptr failure;
  try {
    bytes = std::make_shared<const std::vector<std::byte>>(store.readFile(brick.key));
  } catch (...) {
    failure = std::current_exception();
  }
  lock.lock();
  being_read_.erase(brick);
  // Threads wake after the lock is released, also by an exception of `keep`. A file that is not kept is read again, and
  // each thread gets the failure.
  changed_.notify_all();
  if (failure) std::rethrow_exception(failure);
  keep(brick, bytes, likely);
  return {std::move(bytes), true};
}

void EncodedBricks::keep(const StoredBrick& brick, Bytes bytes, bool likely) {
  if (bytes->size() > budget_bytes_) return;
  // Both allocations come before the first change that stays.
  Recency kept;
  kept.emplace_front(brick, std::move(bytes));
  places_.emplace(brick, kept.begin());
  held_bytes_ += kept.front().second->size();
  recency_.splice(likely ? recency_.begin() : recency_.end(), kept);
  while (held_bytes_ > budget_bytes_) {
    held_bytes_ -= recency_.back().second->size();
    places_.erase(recency_.back().first);
    recency_.pop_back();
  }
}

}  // namespace kiln
