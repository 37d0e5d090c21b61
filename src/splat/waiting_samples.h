// Samples on their way to their slabs: a list for each slab, in chunks that the next slabs use again, so that memory
// grows with the samples that wait at a time and not with the volume's depth. A sweep goes through the slabs from the
// first to the last. A list has no order: sums over it are exact (splat/sheet.h).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "splat/refine_unit.h"

namespace kiln {

class WaitingSamples {
 public:
  /// Empties the lists and makes `slabs` of them.
  void reset(std::size_t slabs);
  void add(std::size_t slab, const SlabSample& sample) {
    Chunk* last = slabs_[slab];
    if (last == nullptr || last->count == kOfChunk) last = extend(slab);
    last->samples[static_cast<std::size_t>(last->count++)] = sample;
  }
  /// Calls each(std::span<const SlabSample>) with all the samples of the slab, some at a time, and forgets them.
  template <class Each>
  void take(std::size_t slab, Each&& each) {
    for (Chunk* chunk = std::exchange(slabs_[slab], nullptr); chunk != nullptr;) {
      each(std::span<const SlabSample>(chunk->samples.data(), static_cast<std::size_t>(chunk->count)));
      Chunk* const next = std::exchange(chunk->next, free_);
      free_ = chunk;
      chunk = next;
    }
  }
  /// What it holds, and keeps for the next sweep. unit: bytes.
  std::size_t bytes() const;

 private:
  static constexpr int kOfChunk = 63;
  struct Chunk {
    std::array<SlabSample, kOfChunk> samples;
    Chunk* next;
    int count;
  };
  Chunk* extend(std::size_t slab);

  std::vector<std::unique_ptr<Chunk>> chunks_;
  std::vector<Chunk*> slabs_;
  Chunk* free_ = nullptr;
};

}  // namespace kiln
