// Invariant: every decoded entry has its place in `decoded_`, and `used_bytes_` is the sum of the entries' charges. An
// entry may be dropped while threads use its block: they keep the block and charge nothing.
#include "ingest/bytes/block_cache.h"

#include <iterator>

namespace kiln {

BlockCache::Bytes BlockCache::Spares::take() {
  const std::scoped_lock lock(mutex_);
  if (spares_.empty()) return {};
  Bytes out = std::move(spares_.back());
  spares_.pop_back();
  return out;
}

void BlockCache::Spares::put(Bytes bytes) {
  const std::scoped_lock lock(mutex_);
  if (!bytes.empty() && spares_.size() < kMost) spares_.push_back(std::move(bytes));
}

std::shared_ptr<const BlockCache::Bytes> BlockCache::get(const Key& key,
                                                         const std::function<Bytes(Bytes spare)>& decode,
                                                         const std::optional<Use>& use) {
  const std::shared_ptr<Block> block = find(key, use);
  const std::scoped_lock lock(block->mutex);
  if (!block->bytes) {
    makeRoom(key);
    block->bytes = decoded(decode);
    ++decodings_;
    charge(key, block);
  }
  return block->bytes;
}

// A block's memory is spared when the cache and all threads have dropped the block.
std::shared_ptr<const BlockCache::Bytes> BlockCache::decoded(const std::function<Bytes(Bytes spare)>& decode) {
  auto bytes = std::make_unique<Bytes>(decode(spares_->take()));
  return std::shared_ptr<Bytes>(bytes.release(), [spares = spares_](Bytes* dropped) {
    spares->put(std::move(*dropped));
    delete dropped;
  });
}

// Without an order, times are negative and fall: the block that was used first is due last.
ReadTime BlockCache::dueOf(const std::optional<Use>& use) {
  if (!order_ || !use) return -++uses_;
  return order_->nextUse(use->block, order_->timeOfBox(use->box));
}

std::shared_ptr<BlockCache::Block> BlockCache::find(const Key& key, const std::optional<Use>& use) {
  const std::scoped_lock lock(mutex_);
  const auto [it, added] = entries_.try_emplace(key);
  Entry& entry = it->second;
  if (added) entry.block = std::make_shared<Block>();
  const ReadTime due = dueOf(use);
  if (decoded_.erase({entry.due, key}) > 0) decoded_.insert({due, key});
  entry.due = due;
  return entry.block;
}

// Drops blocks that are due behind the new one, whose size is taken to be the last one's, so that the new block gets
// their memory.
void BlockCache::makeRoom(const Key& key) {
  const std::scoped_lock lock(mutex_);
  const auto found = entries_.find(key);
  if (found == entries_.end()) return;
  while (used_bytes_ + last_bytes_ > capacity_bytes_ && !decoded_.empty() &&
         decoded_.rbegin()->first > found->second.due)
    dropLast();
}

void BlockCache::charge(const Key& key, const std::shared_ptr<Block>& block) {
  const std::scoped_lock lock(mutex_);
  last_bytes_ = block->bytes->size() + kOwnBytes;
  const auto found = entries_.find(key);
  if (found != entries_.end() && found->second.block == block) {
    found->second.size_bytes = last_bytes_;
    used_bytes_ += last_bytes_;
    decoded_.insert({found->second.due, key});
  }
  while (used_bytes_ > capacity_bytes_ && !decoded_.empty()) dropLast();
}

void BlockCache::dropLast() {
  const auto last = std::prev(decoded_.end());
  const auto dropped = entries_.find(last->second);
  used_bytes_ -= dropped->second.size_bytes;
  entries_.erase(dropped);
  decoded_.erase(last);
}

}  // namespace kiln
