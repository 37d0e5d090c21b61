// What the ranks of one conversion tell each other while they work: pieces of bricks to the one that builds a parent of
// theirs; to the first, which keeps the journal for all, bricks that are on the disk, and at last what was counted. A
// rank that fails ends the job (cluster/ranks.h), so nothing here waits for one that never answers.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <span>
#include <thread>
#include <vector>

#include "cluster/ranks.h"
#include "convert/pyramid/half_brick.h"
#include "convert/resume/journal.h"

namespace kiln {

class RankExchange {
 public:
  struct Handlers {
    /// A piece of a brick of another rank, for this one's parents of it; none where the brick has one value. Of the
    /// brick only key and entry.
    std::function<void(const FinishedBrick&, std::optional<HalfBrick>)> given;
    /// On the first: another rank has written a brick.
    std::function<void(const FinishedBrick&)> finished;
  };

  /// At most `most_bytes` of pieces, but one at least, are on their way from this rank. requires: all outlive this.
  /// thread: the handlers are called by one of this object's own.
  RankExchange(Ranks& ranks, std::uint64_t most_bytes, Handlers handlers);
  RankExchange(const RankExchange&) = delete;
  RankExchange& operator=(const RankExchange&) = delete;

  /// Waits while too much is on its way. thread: safe, as all that follows. throws: what a handler threw.
  void give(int to, const BrickKey& key, const BrickEntry& entry, const HalfBrick* piece);
  /// requires: not the first rank.
  void tellFinished(const FinishedBrick& brick);
  /// throws: what a handler threw.
  void throwIfFailed();

  /// Not the first: hands over what this rank found, all of whose bricks are written and told.
  void tellFound(std::span<const std::byte> found);
  /// The first: waits for what all others found; by rank, its own is empty. throws: what a handler threw.
  std::vector<std::vector<std::byte>> awaitFound();

 private:
  void serve(const std::stop_token& stop);
  void handle(const RankMessage& message);
  template <class Ready>
  void await(std::unique_lock<std::mutex>& lock, const Ready& ready);

  Ranks& ranks_;
  const std::uint64_t most_bytes_;
  const Handlers handlers_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::uint64_t given_bytes_ = 0;
  std::exception_ptr failure_;
  std::vector<std::vector<std::byte>> found_;  // by rank
  int finders_ = 1;                            // ranks that have told it, the first included
  std::jthread service_;
};

}  // namespace kiln
