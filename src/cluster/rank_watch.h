// Problem: a rank that is stopped, or whose disk (NFS) does not answer, keeps all others waiting without end.
// Method: each rank sends a pulse once a second with the time since it last worked. A rank works if it finished a read
// or write, used processor time, or waited for other ranks. The first rank watches all others; they watch the first.
// Invariant: a rank that waits for a hung rank is never named itself.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace kiln {

/// A message of one rank about itself. shape: sent as it is in memory.
struct Pulse {
  double idle_s = 0;      // since the rank last worked
  std::int32_t last = 0;  // 1 if no other pulse follows
  char host[60] = {};     // ends with 0
};

/// thread: `noteWaiting` from any thread; all else from one thread at a time.
class RankWatch {
 public:
  using Clock = std::chrono::steady_clock;
  using Found = std::function<void(const std::string& sentence)>;

  /// `seconds`: a rank is silent if it has not worked for so long. requires: seconds > 0.
  RankWatch(int rank, int count, double seconds, Found found, Clock::time_point now = Clock::now());

  /// This rank waits for other ranks, which counts as work.
  void noteWaiting() { waiting_.fetch_add(1, std::memory_order_relaxed); }
  /// Returns the pulse to send if one is due. requires: called every few milliseconds.
  std::optional<Pulse> ownPulse(Clock::time_point now = Clock::now());
  /// Returns the pulse that ends this rank's. After it `ownPulse` returns nothing.
  Pulse lastPulse();
  void heard(int rank, const Pulse& pulse, Clock::time_point now = Clock::now());
  /// Returns whether every watched rank has sent its last pulse.
  bool allEnded() const;
  /// Returns the silent ranks in a sentence; empty if there are none.
  std::string silentRanks(Clock::time_point now = Clock::now()) const;
  const Found& found() const { return found_; }

 private:
  struct Watched {
    int rank = 0;
    Clock::time_point heard;
    double idle_s = 0;
    bool ended = false;
    std::string host;
  };
  bool worked(double interval_s);

  const int rank_;
  const double seconds_, interval_s_;
  const Found found_;
  const std::string host_;
  std::vector<Watched> watched_;
  Clock::time_point called_, sent_, worked_;
  bool begun_ = false, ended_ = false;
  std::uint64_t io_ = 0, waits_ = 0;
  double processor_s_ = 0;
  std::atomic<std::uint64_t> waiting_ = 0;
};

}  // namespace kiln
