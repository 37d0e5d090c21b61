// Messages between the ranks of a conversion: pieces of bricks for the builders of parents; finished bricks for the
// first rank, which keeps the journal; and final results. A rank that fails ends the job (cluster/ranks.h), so no
// timeout is needed.
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
    /// Receives a piece of another rank's brick for this rank's parents; no piece for a constant brick. Only key and
    /// entry of the brick are set.
    std::function<void(const FinishedBrick&, std::optional<HalfBrick>)> given;
    /// First rank: another rank has written a brick.
    std::function<void(const FinishedBrick&)> finished;
  };

  /// At most `most_bytes` of pieces, but at least one piece, are on their way from this rank. requires: all outlive
  /// this.
  /// thread: the handlers are called by a thread of this object.
  RankExchange(Ranks& ranks, std::uint64_t most_bytes, Handlers handlers);
  RankExchange(const RankExchange&) = delete;
  RankExchange& operator=(const RankExchange&) = delete;

  /// Sends a piece; waits while too many bytes are on their way. thread: safe, as all functions below. throws: the
  /// exception of a handler.
  void give(int to, const BrickKey& key, const BrickEntry& entry, const HalfBrick* piece);
  /// Reports a brick on the disk to the first rank. requires: not the first rank.
  void sendFinished(const FinishedBrick& brick);
  /// throws: the exception of a handler.
  void throwIfFailed();

  /// Sends the results of this rank (errors, report, counts). requires: not the first rank; all its bricks are written
  /// and reported.
  void sendResults(std::span<const std::byte> results);
  /// Waits for the results of all other ranks; by rank, empty for the first. requires: the first rank.
  /// throws: the exception of a handler.
  std::vector<std::vector<std::byte>> awaitResults();

 private:
  void serve(const std::stop_token& stop);
  void handle(const RankMessage& message);
  template <class Ready>
  void await(std::unique_lock<std::mutex>& lock, const Ready& ready);

  Ranks& ranks_;
  const std::uint64_t most_bytes_;
  const Handlers handlers_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::uint64_t given_bytes_ = 0;
  std::exception_ptr failure_;
  std::vector<std::vector<std::byte>> results_;  // by rank
  int reported_ranks_ = 1;                       // ranks whose results have arrived, the first included
  std::jthread service_;
};

}  // namespace kiln
