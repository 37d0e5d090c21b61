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
  if (bytes) keep(brick, bytes, likely);
  changed_.notify_all();
  // Waiting threads read again and get the failure, too.
  if (failure) std::rethrow_exception(failure);
  return {std::move(bytes), true};
}

void EncodedBricks::keep(const StoredBrick& brick, Bytes bytes, bool likely) {
  if (bytes->size() > budget_bytes_) return;
  held_bytes_ += bytes->size();
  places_[brick] = recency_.emplace(likely ? recency_.begin() : recency_.end(), brick, std::move(bytes));
  while (held_bytes_ > budget_bytes_) {
    held_bytes_ -= recency_.back().second->size();
    places_.erase(recency_.back().first);
    recency_.pop_back();
  }
}

}  // namespace kiln
