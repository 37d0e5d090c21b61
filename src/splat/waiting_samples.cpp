#include "splat/waiting_samples.h"

namespace kiln {

void WaitingSamples::reset(std::size_t slabs) {
  for (std::size_t slab = 0; slab < slabs_.size(); ++slab) take(slab, [](std::span<const SlabSample>) {});
  slabs_.resize(slabs);
}

WaitingSamples::Chunk* WaitingSamples::extend(std::size_t slab) {
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

std::size_t WaitingSamples::bytes() const {
  return chunks_.size() * (sizeof(Chunk) + sizeof(Chunk*)) + slabs_.capacity() * sizeof(Chunk*);
}

}  // namespace kiln
