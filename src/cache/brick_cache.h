// A cache of decoded bricks under a memory budget, with reading ahead of the frame.
// Method. A brick is charged before it is read, including the working memory of its decoding. The least recently used
// brick is evicted first. Held bricks stay; announced bricks are evicted only for a request without room.
// Invariant. Charges of bricks never exceed the budget; with a part set aside, only bricks held before may exceed the
// rest. A brick in memory, or being read, is not read again. An unreadable brick is read again at each request, unless
// unreadable bricks are skipped and the file is damaged or missing.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "base/error.h"
#include "cache/brick_files.h"
#include "store/bricked_volume.h"

namespace kiln {

struct BrickEntry;

struct CacheCounts {
  std::uint64_t reads = 0;       // bricks decoded from a file read from disk by this cache
  std::uint64_t read_bytes = 0;  // bytes of these files
  std::uint64_t shared = 0;      // bricks decoded from a file in the memory of any rank
  std::uint64_t shared_bytes = 0;
  std::uint64_t constants = 0;  // bricks made without a file
  std::uint64_t emptied = 0;    // bricks that were not read because their mask turned out to be empty
  std::uint64_t companion_reads = 0, companion_bytes = 0;  // bricks of companions, such as masks, and their files
  std::uint64_t hits = 0;                                  // requested bricks that were in memory or being read
  std::uint64_t unused = 0;                                // bricks read ahead and evicted without a request
  std::uint64_t skipped = 0;  // requests that returned null because the brick is unreadable
  double load_seconds = 0;    // time spent in `get`
};

/// A brick that will probably be requested soon.
struct NextBrick {
  StoredBrick brick;
  bool read = true;  // read ahead; if false, only room is kept for the brick, not taken by later bricks
};

class BrickCache {
 public:
  class Aside;
  /// Receives the error of a skipped brick: of a damaged or missing brick once, of a failed read at each request.
  using SkipHandler = std::function<void(const Error&)>;

  /// `readers` threads read announced bricks; with 0 nothing is read ahead. With `skip`, an unreadable brick is no
  /// error. With `supplier`, bricks that are not constant come from there. throws: Error kBudget, naming the smallest
  /// sufficient budget, if the largest brick does not fit.
  BrickCache(const BrickedVolume& store, std::uint64_t budget_bytes, unsigned readers = 0, SkipHandler skip = {})
      : BrickCache(std::vector<const BrickedVolume*>{&store}, budget_bytes, readers, std::move(skip)) {}
  /// A cache for the bricks of several volumes under one budget.
  BrickCache(std::vector<const BrickedVolume*> stores, std::uint64_t budget_bytes, unsigned readers = 0,
             SkipHandler skip = {}, BrickSupplier* supplier = nullptr);
  ~BrickCache();
  BrickCache(const BrickCache&) = delete;
  BrickCache& operator=(const BrickCache&) = delete;

  /// Returns a brick from memory or disk; the brick stays while the caller holds the pointer. Returns null for an
  /// unreadable brick if `skip` is set. Each request reads a brick again that could not be read before, except damaged
  /// and missing bricks if `skip` is set.
  /// thread: one caller at a time.
  /// throws: Error kBudget if held bricks leave no room; any exception of BrickedVolume::read.
  std::shared_ptr<const BrickBlock> get(const StoredBrick& brick);
  std::shared_ptr<const BrickBlock> get(const BrickKey& key) { return get(StoredBrick{key}); }

  /// Returns a brick of the first store if it is in memory, else null. Never waits, reads or throws. thread: as `get`.
  std::shared_ptr<const BrickBlock> find(const BrickKey& key);

  /// Returns whether a brick is in memory or being read. Changes nothing. thread: as `get`.
  bool holds(const StoredBrick& brick) const;

  /// Announces the next requests, in order. Announced bricks are read while room is left beside held and announced
  /// bricks. A new list replaces the old one, except for bricks already being read. A request removes the requested
  /// brick and all bricks before it from the list. An unreadable brick is no error until it is requested. thread: as
  /// `get`.
  void announce(std::span<const NextBrick> next);
  /// True if announced bricks are read ahead.
  bool readsAhead() const { return !readers_.empty(); }
  /// Clears the announcements and waits until no brick is being read.
  void settle();

  /// thread: as `get`; exact after `settle`.
  CacheCounts counts() const;
  std::uint64_t budgetBytes() const { return budget_bytes_; }
  /// Returns the budget without the parts set aside. thread: safe. unit: bytes.
  std::uint64_t bricksBytes() const;
  const std::vector<const BrickedVolume*>& stores() const { return stores_; }
  /// Largest charge at any time. unit: bytes.
  std::uint64_t peakBytes() const;

 private:
  enum class State { kReading, kReady, kFailed };
  struct Slot {
    State state = State::kReading;
    std::uint64_t charged_bytes = 0;
    bool asked_for = false;
    bool awaited = false;  // `get` waits for the brick, which must not be evicted
    std::shared_ptr<const BrickBlock> block;
    std::exception_ptr failure;
    std::list<StoredBrick>::iterator recency;  // unset for a failed brick, which costs nothing
  };
  using Slots = std::map<StoredBrick, Slot>;
  using Announced = std::deque<NextBrick>;
  using Lock = std::unique_lock<std::mutex>;

  Announced::const_iterator announced(const StoredBrick& brick) const;
  const StoredBrick* nextToRead();
  bool fits(std::uint64_t bytes) const { return held_bytes_ + bytes + aside_bytes_ <= budget_bytes_; }
  bool mayEvict(const StoredBrick& brick, bool spare_announced) const;
  std::uint64_t evictableBytes(std::uint64_t enough_bytes, bool spare_announced) const;
  void evict(std::uint64_t bytes, bool spare_announced);
  void replaceAside(std::uint64_t old_bytes, std::uint64_t new_bytes);
  bool makeRoom(std::uint64_t bytes, bool spare_announced);
  Slots::iterator begin(const StoredBrick& brick);
  void read(Slots::iterator slot, Lock& lock);
  void countRead(const BrickEntry& entry, const BrickBlock& block, bool from_disk);
  std::shared_ptr<const BrickBlock> skip(const std::exception_ptr& failure, bool first, Lock& lock);
  void erase(Slots::iterator slot);
  void noteFreed(std::uint64_t bytes);
  void passTurnsUpTo(const StoredBrick& brick);
  void readAhead();

  const BrickedVolume& storeOf(const StoredBrick& brick) const {
    return *stores_[static_cast<std::size_t>(brick.store)];
  }

  const std::vector<const BrickedVolume*> stores_;
  const std::uint64_t budget_bytes_;
  const bool mixed_sizes_, small_bricks_;
  const SkipHandler skip_;
  BrickSupplier* const supplier_;
  std::atomic<std::uint64_t> freed_bytes_ = 0;  // since the heap last returned freed memory
  mutable std::mutex mutex_;                    // guards the members below
  std::condition_variable changed_;
  std::uint64_t held_bytes_ = 0, aside_bytes_ = 0, peak_bytes_ = 0;
  int reading_ = 0;
  bool closing_ = false;
  bool starved_ = false;  // `get` waits for room
  Slots slots_;
  std::list<StoredBrick> recency_;  // most recent first
  Announced announced_;             // not requested yet; next first
  CacheCounts counts_;
  std::vector<std::thread> readers_;
};

/// A part of the budget that bricks leave free while the object lives, for other buffers of the caller. Parts add up.
/// Bricks that are held or being read stay. thread: as `get`. requires: the parts are at most the budget; the cache
/// outlives the object. unit: bytes.
class BrickCache::Aside {
 public:
  explicit Aside(BrickCache& cache, std::uint64_t bytes = 0) : cache_(cache) { resize(bytes); }
  ~Aside() { resize(0); }
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;

  void resize(std::uint64_t bytes) { cache_.replaceAside(std::exchange(bytes_, bytes), bytes); }

 private:
  BrickCache& cache_;
  std::uint64_t bytes_ = 0;
};

}  // namespace kiln
