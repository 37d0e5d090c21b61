// Decoded bricks in memory, never more than the user said, and read ahead of the frame. Every byte a brick costs is
// charged before it is read, those that its decoding needs for a moment included; the least recently used brick that
// nobody holds and nobody has announced makes room. A brick is read once however often it is asked for and announced;
// one that cannot be read is not tried again.
#pragma once

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
#include "store/store_reader.h"

namespace kiln {

struct CacheCounts {
  std::uint64_t reads = 0;       // bricks decoded from a file that was read from the disk for them
  std::uint64_t read_bytes = 0;  // of those files
  std::uint64_t shared = 0;      // bricks decoded from a file that was in memory, here or elsewhere
  std::uint64_t shared_bytes = 0;
  std::uint64_t constants = 0;  // bricks made without a file
  std::uint64_t hits = 0;       // bricks that were there, or on their way, when they were asked for
  std::uint64_t unused = 0;     // bricks read ahead that made room again before anyone asked
  std::uint64_t skipped = 0;    // times that `get` gave nothing, because the brick cannot be read
  double load_seconds = 0;      // that `get` took
};

/// A brick that may be asked for soon.
struct NextBrick {
  StoredBrick brick;
  bool read = true;  // ahead of that; else what comes after it leaves room for it, so as not to be in its way
};

class BrickCache {
 public:
  /// Told of a brick that is damaged, missing or cannot be read, once for each, when it is first asked for.
  using SkipHandler = std::function<void(const Error&)>;

  /// `readers` threads read what is announced; 0 reads nothing ahead. With `skip`, a brick that cannot be read is no
  /// error. With `files`, brick files come from there. throws: Error kBudget where the largest brick does not fit,
  /// naming the smallest budget that works.
  BrickCache(const StoreReader& store, std::uint64_t budget_bytes, unsigned readers = 0, SkipHandler skip = {})
      : BrickCache(std::vector<const StoreReader*>{&store}, budget_bytes, readers, std::move(skip)) {}
  /// The same of several stores, whose bricks have the budget together.
  BrickCache(std::vector<const StoreReader*> stores, std::uint64_t budget_bytes, unsigned readers = 0,
             SkipHandler skip = {}, BrickFiles* files = nullptr);
  ~BrickCache();
  BrickCache(const BrickCache&) = delete;
  BrickCache& operator=(const BrickCache&) = delete;

  /// The brick, from memory or from disk; it stays while the caller holds it. Null where it cannot be read and such
  /// bricks are skipped. thread: one caller at a time.
  /// throws: Error kBudget where held bricks leave no room, and what StoreReader::read throws.
  std::shared_ptr<const BrickBlock> get(const StoredBrick& brick);
  std::shared_ptr<const BrickBlock> get(const BrickKey& key) { return get(StoredBrick{key}); }

  /// The same where it is in memory already, and nothing otherwise: it neither waits nor reads nor fails. thread: as
  /// `get`. Of a cache of several stores, of the first.
  std::shared_ptr<const BrickBlock> find(const BrickKey& key);

  /// Says which bricks will be asked for next, in that order: they are read as far as there is room beside what is held
  /// and announced. What was announced before and is not now is dropped, if its reading has not begun, and so is what
  /// stands before a brick that is asked for. A brick that cannot be read is no error before it is asked for. thread:
  /// as `get`.
  void announce(std::span<const NextBrick> next);
  /// Whether announcing gains anything.
  bool readsAhead() const { return !readers_.empty(); }
  /// Announces nothing, and waits until nothing is being read.
  void settle();

  /// thread: as `get`, and exact after `settle`.
  CacheCounts counts() const;
  std::uint64_t budgetBytes() const { return budget_bytes_; }
  const std::vector<const StoreReader*>& stores() const { return stores_; }
  /// The most that was charged at any time. unit: bytes.
  std::uint64_t peakBytes() const;

 private:
  enum class State { kReading, kReady, kFailed };
  struct Slot {
    State state = State::kReading;
    std::uint64_t charged_bytes = 0;
    bool asked_for = false;
    bool awaited = false;  // `get` is waiting for it: it stays
    std::shared_ptr<const BrickBlock> block;
    std::exception_ptr failure;
    std::list<StoredBrick>::iterator recency;  // not where it has failed: that costs nothing and stays
  };
  using Slots = std::map<StoredBrick, Slot>;
  using Announced = std::deque<NextBrick>;
  using Lock = std::unique_lock<std::mutex>;

  Announced::const_iterator announced(const StoredBrick& brick) const;
  const StoredBrick* nextToRead();
  bool makeRoom(std::uint64_t bytes, bool spare_announced);
  Slots::iterator begin(const StoredBrick& brick);
  void read(Slots::iterator slot, Lock& lock);
  std::shared_ptr<const BrickBlock> skip(const Slot& failed, bool first, Lock& lock);
  void erase(Slots::iterator slot);
  void passTurnsUpTo(const StoredBrick& brick);
  void readAhead();

  const StoreReader& storeOf(const StoredBrick& brick) const { return *stores_[static_cast<std::size_t>(brick.store)]; }

  const std::vector<const StoreReader*> stores_;
  const std::uint64_t budget_bytes_;
  const SkipHandler skip_;
  BrickFiles* const files_;
  mutable std::mutex mutex_;  // guards all below
  std::condition_variable changed_;
  std::uint64_t held_bytes_ = 0, peak_bytes_ = 0;
  int reading_ = 0;
  bool closing_ = false;
  bool starved_ = false;  // `get` is waiting for room
  Slots slots_;
  std::list<StoredBrick> recency_;  // most recent first
  Announced announced_;             // not asked for yet; the next first
  CacheCounts counts_;
  std::vector<std::thread> readers_;
};

}  // namespace kiln
