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

namespace kiln {

template <class Sample>
class WaitingSamples {
 public:
  /// Empties the lists and makes `slabs` of them.
  void reset(std::size_t slabs) {
    for (std::size_t slab = 0; slab < slabs_.size(); ++slab) take(slab, [](std::span<const Sample>) {});
    slabs_.resize(slabs);
  }
  /// One more sample of the slab, to be written at once.
  Sample& add(std::size_t slab) {
    Chunk* last = slabs_[slab];
    if (last == nullptr || last->count == kOfChunk) last = extend(slab);
    return last->samples[static_cast<std::size_t>(last->count++)];
  }
  /// Calls each(std::span<const Sample>) with all the samples of the slab, some at a time, and forgets them.
  template <class Each>
  void take(std::size_t slab, Each&& each) {
    for (Chunk* chunk = std::exchange(slabs_[slab], nullptr); chunk != nullptr;) {
      each(std::span<const Sample>(chunk->samples.data(), static_cast<std::size_t>(chunk->count)));
      Chunk* const next = std::exchange(chunk->next, free_);
      free_ = chunk;
      chunk = next;
    }
  }
  /// What it holds, and keeps for the next sweep. unit: bytes.
  std::size_t bytes() const {
    return chunks_.size() * (sizeof(Chunk) + sizeof(Chunk*)) + slabs_.capacity() * sizeof(Chunk*);
  }

 private:
  static constexpr int kOfChunk = 63;
  struct Chunk {
    std::array<Sample, kOfChunk> samples;
    Chunk* next;
    int count;
  };

  // Once in 63 samples: `add` stays small without it.
  [[gnu::noinline]] Chunk* extend(std::size_t slab) {
    if (free_ == nullptr) {
      chunks_.push_back(std::make_unique_for_overwrite<Chunk>());
      free_ = chunks_.back().get();
      free_->next = nullptr;
    }
    Chunk* const out = std::exchange(free_, free_->next);
    out->next = std::exchange(slabs_[slab], out);
    out->count = 0;
    return out;
  }

  std::vector<std::unique_ptr<Chunk>> chunks_;
  std::vector<Chunk*> slabs_;
  Chunk* free_ = nullptr;
};

}  // namespace kiln
