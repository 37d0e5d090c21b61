#include "cache/brick_cache.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <system_error>
#include <utility>

#include "base/elapsed.h"
#include "base/memory/memory.h"
#include "base/thread/profile_scope.h"
#include "base/thread/trace.h"
#include "store/brick_index.h"

namespace kiln {
namespace {

// Most freed memory that stays in the heap as gaps between bricks. unit: bytes.
constexpr std::uint64_t kMostFreed = std::uint64_t{8} << 20;

// Largest voxels of a brick whose file leaves a gap between bricks: decoding frees a file that is larger than the next
// brick, which fills a part of the gap. unit: bytes.
constexpr std::uint64_t kSmallBrick = std::uint64_t{128} << 10;

bool differInSize(const std::vector<const BrickedVolume*>& stores) {
  const auto voxels = [](const BrickedVolume* store) {
    return std::pair(store->manifest().brick_size, sizeOf(store->manifest().type));
  };
  return std::any_of(stores.begin(), stores.end(),
                     [&](const BrickedVolume* store) { return voxels(store) != voxels(stores.front()); });
}

bool areSmall(const BrickedVolume& store) {
  const Manifest& manifest = store.manifest();
  const auto edge = static_cast<std::uint64_t>(manifest.brick_size + 2 * manifest.apron);
  return edge * edge * edge * sizeOf(manifest.type) <= kSmallBrick;
}

// Returns whether a brick stays unreadable, because its file is damaged or missing. A lack of memory, or a failed read
// of the system, may pass.
bool lasts(const std::exception_ptr& failure) {
  try {
    std::rethrow_exception(failure);
  } catch (const Error& error) {
    return error.code() != ErrorCode::kIo && error.code() != ErrorCode::kReplaced;
  } catch (...) {
    return false;
  }
}

}  // namespace

BrickCache::BrickCache(std::vector<const BrickedVolume*> stores, std::uint64_t budget_bytes, unsigned readers,
                       SkipHandler skip, BrickSupplier* supplier)
    : stores_(std::move(stores)),
      budget_bytes_(budget_bytes),
      mixed_sizes_(differInSize(stores_)),
      small_bricks_(std::ranges::any_of(stores_, [](const BrickedVolume* store) { return areSmall(*store); })),
      skip_(std::move(skip)),
      supplier_(supplier) {
  for (const BrickedVolume* const store : stores_) {
    const std::uint64_t smallest = store->largestReadBytes();
    if (smallest <= budget_bytes) continue;
    throw Error(ErrorCode::kBudget, store->path(), "--memory",
                fmt::format("{} is too little: reading one brick takes {}; give at least that",
                            formatBytes(budget_bytes), formatBytes(smallest)));
  }
  try {
    for (unsigned i = 0; i < readers; ++i) readers_.emplace_back([this] { readAhead(); });
  } catch (const std::system_error&) {
    // The system allows no more threads (ulimit -u, -v): the threads made so far read ahead, if any.
  }
}

BrickCache::~BrickCache() {
  {
    const Lock lock(mutex_);
    closing_ = true;
  }
  changed_.notify_all();
  for (std::thread& reader : readers_) reader.join();
}

BrickCache::Announced::const_iterator BrickCache::announced(const StoredBrick& brick) const {
  return std::find_if(announced_.begin(), announced_.end(), [&](const NextBrick& next) { return next.brick == brick; });
}

void BrickCache::erase(Slots::iterator slot) {
  if (!slot->second.asked_for) ++counts_.unused;
  const std::uint64_t bytes = slot->second.charged_bytes;
  held_bytes_ -= bytes;
  recency_.erase(slot->second.recency);
  slots_.erase(slot);
  // No large brick fits into a gap between small bricks.
  if (mixed_sizes_) noteFreed(bytes);
}

void BrickCache::noteFreed(std::uint64_t bytes) {
  // One of several threads beyond the limit returns the memory.
  if ((freed_bytes_ += bytes) >= kMostFreed && freed_bytes_.exchange(0) >= kMostFreed) returnFreedMemory();
}

// Returns false for bricks held, awaited or being read.
bool BrickCache::mayEvict(const StoredBrick& brick, bool spare_announced) const {
  const Slot& slot = slots_.find(brick)->second;
  if (slot.state == State::kReading || slot.awaited || slot.block.use_count() > 1) return false;
  return !spare_announced || announced(brick) == announced_.end();
}

// Sums the bricks that may be evicted, the oldest first, and stops at `enough_bytes`.
std::uint64_t BrickCache::evictableBytes(std::uint64_t enough_bytes, bool spare_announced) const {
  std::uint64_t sum = 0;
  for (auto brick = recency_.rbegin(); brick != recency_.rend() && sum < enough_bytes; ++brick) {
    if (mayEvict(*brick, spare_announced)) sum += slots_.find(*brick)->second.charged_bytes;
  }
  return sum;
}

// Evicts bricks until `bytes` fit or no more may be evicted.
void BrickCache::evict(std::uint64_t bytes, bool spare_announced) {
  for (auto oldest = recency_.end(); oldest != recency_.begin() && !fits(bytes);) {
    --oldest;
    if (!mayEvict(*oldest, spare_announced)) continue;
    const auto slot = slots_.find(*oldest++);
    erase(slot);
  }
}

// Evicts bricks until `bytes` fit, announced bricks last. Returns false, and evicts nothing, if too few may be evicted.
bool BrickCache::makeRoom(std::uint64_t bytes, bool spare_announced) {
  if (fits(bytes)) return true;
  const std::uint64_t lacking = held_bytes_ + bytes + aside_bytes_ - budget_bytes_;
  if (evictableBytes(lacking, spare_announced) < lacking) return false;
  evict(bytes, true);
  if (!spare_announced) evict(bytes, false);
  return true;
}

std::uint64_t BrickCache::bricksBytes() const {
  const Lock lock(mutex_);
  return budget_bytes_ - std::min(budget_bytes_, aside_bytes_);
}

void BrickCache::replaceAside(std::uint64_t old_bytes, std::uint64_t new_bytes) {
  const Lock lock(mutex_);
  aside_bytes_ = aside_bytes_ - old_bytes + new_bytes;
  if (new_bytes <= old_bytes) return;
  evict(0, true);
  evict(0, false);
}

// Charges a brick before its reading begins. requires: room.
BrickCache::Slots::iterator BrickCache::begin(const StoredBrick& brick) {
  recency_.push_front(brick);
  Slot slot;
  slot.charged_bytes = storeOf(brick).readBytes(brick.key);
  slot.recency = recency_.begin();
  held_bytes_ += slot.charged_bytes;
  peak_bytes_ = std::max(peak_bytes_, held_bytes_);
  ++reading_;
  return slots_.emplace(brick, std::move(slot)).first;
}

// Reads a brick without the lock. A failure is stored for the request.
void BrickCache::read(Slots::iterator slot, Lock& lock) {
  const StoredBrick brick = slot->first;
  const BrickedVolume& store = storeOf(brick);
  const BrickEntry& entry = store.index().at(brick.key);
  std::shared_ptr<const BrickBlock> block;
  std::exception_ptr failure;
  bool from_disk = true;
  lock.unlock();
  try {
    if (supplier_ != nullptr && !entry.constant) {
      SuppliedBrick supplied = supplier_->supply(brick);
      from_disk = supplied.from_disk;
      block = std::make_shared<const BrickBlock>(std::move(supplied.block));
    } else {
      block = std::make_shared<const BrickBlock>(store.read(brick.key));
    }
  } catch (...) {
    failure = std::current_exception();
  }
  if (small_bricks_) noteFreed(entry.file_bytes);
  lock.lock();
  --reading_;
  Slot& done = slot->second;
  held_bytes_ -= done.charged_bytes;
  done.charged_bytes = block ? block->bytes() : 0;
  held_bytes_ += done.charged_bytes;
  done.state = block ? State::kReady : State::kFailed;
  done.block = std::move(block);
  done.failure = failure;
  if (failure) recency_.erase(done.recency);
  if (done.block) countRead(entry, *done.block, from_disk);
  changed_.notify_all();
}

void BrickCache::countRead(const BrickEntry& entry, const BrickBlock& block, bool from_disk) {
  counts_.companion_reads += block.companion_reads;
  counts_.companion_bytes += block.companion_bytes;
  if (block.masked) {
    ++counts_.emptied;
    return;
  }
  ++(entry.constant || block.constant ? counts_.constants : from_disk ? counts_.reads : counts_.shared);
  (from_disk ? counts_.read_bytes : counts_.shared_bytes) += entry.file_bytes;
}

std::shared_ptr<const BrickBlock> BrickCache::get(const StoredBrick& brick) {
  const auto begun = std::chrono::steady_clock::now();
  const ProfileScope span(Activity::kWait);
  Lock lock(mutex_);
  passTurnsUpTo(brick);
  auto slot = slots_.find(brick);
  if (slot != slots_.end()) {
    if (slot->second.state != State::kFailed) recency_.splice(recency_.begin(), recency_, slot->second.recency);
    slot->second.awaited = true;
    changed_.wait(lock, [&] { return slot->second.state != State::kReading; });
    slot->second.awaited = false;
    if (slot->second.state == State::kFailed && !(skip_ && lasts(slot->second.failure))) {
      slots_.erase(slot);
      slot = slots_.end();
    } else {
      ++counts_.hits;
    }
  }
  if (slot == slots_.end()) {
    const std::uint64_t needed = storeOf(brick).readBytes(brick.key);
    // A brick being read ahead shrinks to its decoded size when ready, and can then be evicted.
    while (!makeRoom(needed, true) && !makeRoom(needed, false)) {
      starved_ = reading_ > 0;
      if (!starved_) {
        const std::uint64_t in_use = held_bytes_ + aside_bytes_ - evictableBytes(held_bytes_, false);
        throw Error(ErrorCode::kBudget, storeOf(brick).path(), "--memory",
                    fmt::format("{} is too little: {} are in use and the next brick takes {}",
                                formatBytes(budget_bytes_), formatBytes(in_use), formatBytes(needed)));
      }
      changed_.wait(lock);
    }
    starved_ = false;
    slot = begin(brick);
    read(slot, lock);
  }
  const bool first = !std::exchange(slot->second.asked_for, true);
  counts_.load_seconds += secondsSince(begun);
  if (slot->second.state != State::kFailed) return slot->second.block;
  const std::exception_ptr failure = slot->second.failure;
  if (!skip_ || !lasts(failure)) slots_.erase(slot);
  if (!skip_) std::rethrow_exception(failure);
  return skip(failure, first, lock);
}

// Bricks announced before a requested brick have become hidden: their turn has passed.
void BrickCache::passTurnsUpTo(const StoredBrick& brick) {
  const auto due = announced(brick);
  if (due != announced_.end()) announced_.erase(announced_.begin(), due + 1);
}

std::shared_ptr<const BrickBlock> BrickCache::find(const BrickKey& key) {
  const Lock lock(mutex_);
  const auto slot = slots_.find({key});
  if (slot == slots_.end() || slot->second.state != State::kReady) return nullptr;
  passTurnsUpTo({key});
  ++counts_.hits;
  recency_.splice(recency_.begin(), recency_, slot->second.recency);
  slot->second.asked_for = true;
  return slot->second.block;
}

bool BrickCache::holds(const StoredBrick& brick) const {
  const Lock lock(mutex_);
  return slots_.contains(brick);
}

std::shared_ptr<const BrickBlock> BrickCache::skip(const std::exception_ptr& failure, bool first, Lock& lock) {
  ++counts_.skipped;
  lock.unlock();
  try {
    std::rethrow_exception(failure);
  } catch (const Error& error) {
    // A replaced store is always an error: the picture would mix two stores.
    if (error.code() == ErrorCode::kReplaced) throw;
    if (first) skip_(error);
  }
  return nullptr;
}

void BrickCache::announce(std::span<const NextBrick> next) {
  if (readers_.empty()) return;
  bool wanted = false;
  {
    const Lock lock(mutex_);
    announced_.assign(next.begin(), next.end());
    wanted = nextToRead() != nullptr;
  }
  // Readers that wake without work would take cores from drawing.
  if (wanted) changed_.notify_all();
}

void BrickCache::settle() {
  Lock lock(mutex_);
  announced_.clear();
  changed_.wait(lock, [&] { return reading_ == 0; });
}

// Returns the first announced brick that is not in memory, if there is room for the brick and all announced before;
// else null.
const StoredBrick* BrickCache::nextToRead() {
  std::uint64_t before_bytes = 0;
  for (const auto& [brick, is_read] : announced_) {
    if (slots_.contains(brick)) continue;
    const std::uint64_t bytes = storeOf(brick).readBytes(brick.key);
    if (is_read) return makeRoom(before_bytes + bytes, true) ? &brick : nullptr;
    before_bytes += bytes;
  }
  return nullptr;
}

// The loop of a reader: reads announced bricks while there is room and `get` does not wait for room. A brick read
// during such a wait would only be evicted and read again.
void BrickCache::readAhead() {
  Trace::nameThread("reads");
  Lock lock(mutex_);
  while (!closing_) {
    const StoredBrick* const next = starved_ ? nullptr : nextToRead();
    if (next == nullptr)
      changed_.wait(lock);
    else
      read(begin(*next), lock);
  }
}

CacheCounts BrickCache::counts() const {
  const Lock lock(mutex_);
  return counts_;
}

std::uint64_t BrickCache::peakBytes() const {
  const Lock lock(mutex_);
  return peak_bytes_;
}

}  // namespace kiln
