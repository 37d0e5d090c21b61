// Invariant: every entry has its place in `uses_`, and `used_bytes_` is the sum of the entries' charges. An entry may
// be dropped while a thread decodes its block: the thread keeps the block and charges nothing.
#include "ingest/bytes/block_cache.h"

namespace kiln {

std::shared_ptr<const BlockCache::Bytes> BlockCache::get(const Key& key, const std::function<Bytes()>& decode) {
  const std::shared_ptr<Block> block = find(key);
  const std::scoped_lock lock(block->mutex);
  if (!block->bytes) {
    block->bytes = std::make_shared<const Bytes>(decode());
    charge(key, block);
  }
  return block->bytes;
}

std::shared_ptr<BlockCache::Block> BlockCache::find(const Key& key) {
  const std::scoped_lock lock(mutex_);
  const auto [it, added] = entries_.try_emplace(key);
  Entry& entry = it->second;
  if (added) {
    entry.block = std::make_shared<Block>();
    entry.use = uses_.insert(uses_.begin(), key);
  } else {
    uses_.splice(uses_.begin(), uses_, entry.use);
  }
  return entry.block;
}

void BlockCache::charge(const Key& key, const std::shared_ptr<Block>& block) {
  const std::scoped_lock lock(mutex_);
  const auto found = entries_.find(key);
  if (found != entries_.end() && found->second.block == block) {
    found->second.size_bytes = block->bytes->size() + kOwnBytes;
    used_bytes_ += found->second.size_bytes;
  }
  while (used_bytes_ > capacity_bytes_ && !uses_.empty()) {
    const auto oldest = entries_.find(uses_.back());
    used_bytes_ -= oldest->second.size_bytes;
    entries_.erase(oldest);
    uses_.pop_back();
  }
}

}  // namespace kiln
