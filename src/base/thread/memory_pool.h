// What threads draw with: lent to one tile at a time, and kept for the next.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace kiln {

/// Of anything that says its `bytes()`. thread: safe.
template <class Memory>
class MemoryPool {
 public:
  /// Calls use(Memory&) with one that nobody else has.
  template <class Use>
  void lend(Use&& use) {
    std::unique_ptr<Memory> memory = take();
    use(*memory);
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(memory));
  }
  /// What threads have needed so far; while nobody draws. unit: bytes.
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
