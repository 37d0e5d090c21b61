// Bricks of a companion that stay in memory in a packed form, the most recent first.
#pragma once

#include <algorithm>
#include <cstddef>
#include <list>
#include <memory>
#include <mutex>
#include <utility>

#include "grid/coords.h"

namespace kiln {

template <class Packed>
class KeptBricks {
 public:
  /// Keeps so many bricks.
  explicit KeptBricks(std::size_t most) : most_(most) {}

  /// Returns a brick from memory, or the result of make(). Two threads that miss a brick at once both make it. thread:
  /// safe.
  template <class Make>
  std::shared_ptr<const Packed> get(const BrickKey& key, const Make& make) {
    if (std::shared_ptr<const Packed> kept = find(key)) return kept;
    auto made = std::make_shared<const Packed>(make());
    const std::lock_guard lock(mutex_);
    bricks_.emplace_front(key, made);
    if (bricks_.size() > most_) bricks_.pop_back();
    return made;
  }

 private:
  using Brick = std::pair<BrickKey, std::shared_ptr<const Packed>>;

  std::shared_ptr<const Packed> find(const BrickKey& key) {
    const std::lock_guard lock(mutex_);
    const auto kept =
        std::find_if(bricks_.begin(), bricks_.end(), [&](const Brick& brick) { return brick.first == key; });
    if (kept == bricks_.end()) return nullptr;
    bricks_.splice(bricks_.begin(), bricks_, kept);
    return kept->second;
  }

  const std::size_t most_;
  std::mutex mutex_;
  std::list<Brick> bricks_;
};

}  // namespace kiln
