// What threads sweep slabs with: lent to one tile at a time, and kept for the next.
#pragma once

#include <memory>
#include <mutex>
#include <vector>

#include "splat/slab_sweep.h"

namespace kiln {

/// thread: safe.
class SweepPool {
 public:
  /// Calls use(SweepMemory&) with one that nobody else has.
  template <class Use>
  void lend(Use&& use) {
    std::unique_ptr<SweepMemory> memory = take();
    use(*memory);
    const std::lock_guard lock(mutex_);
    free_.push_back(std::move(memory));
  }
  /// What threads have needed so far; while none sweeps. unit: bytes.
  std::uint64_t bytes() const {
    const std::lock_guard lock(mutex_);
    std::uint64_t sum = 0;
    for (const std::unique_ptr<SweepMemory>& memory : free_) sum += memory->bytes();
    return sum;
  }

 private:
  std::unique_ptr<SweepMemory> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return std::make_unique<SweepMemory>();
    std::unique_ptr<SweepMemory> out = std::move(free_.back());
    free_.pop_back();
    return out;
  }

  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<SweepMemory>> free_;
};

}  // namespace kiln
