// A pool of per-thread scratch buffers. A tile borrows one while it is drawn.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace kiln {

/// A pool of Memory objects. requires: Memory has a `bytes()`. thread: safe.
template <class Memory>
class MemoryPool {
 public:
  /// Calls use(Memory&) with a buffer that no other thread holds.
  template <class Use>
  void lend(Use&& use) {
    std::unique_ptr<Memory> memory = take();
    use(*memory);
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(memory));
  }
  /// Memory of all buffers made so far. requires: no buffer is lent. unit: bytes.
  std::uint64_t bytes() const {
    const std::lock_guard lock(mutex_);
    std::uint64_t sum = 0;
    for (const std::unique_ptr<Memory>& memory : free_) sum += memory->bytes();
    return sum;
  }

 private:
  std::unique_ptr<Memory> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return std::make_unique<Memory>();
    std::unique_ptr<Memory> out = std::move(free_.back());
    free_.pop_back();
    return out;
  }

  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Memory>> free_;
};

}  // namespace kiln
