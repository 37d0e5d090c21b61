// Detects hung ranks.
// Problem. A stopped rank, or a rank whose disk (NFS) does not answer, keeps all ranks waiting forever.
// Method. Each rank sends a pulse once a second with the time since its last work. Work is a finished read or write,
// used processor time, or a wait for further ranks or another process. All ranks watch rank 0, and rank 0 all ranks.
// Invariant. A rank waiting for a hung rank is never reported.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace kiln {

/// The state of a rank, as a message. shape: sent as stored in memory.
struct Pulse {
  double idle_s = 0;      // since the rank last worked
  std::int32_t last = 0;  // 1 if this is the rank's last pulse
  char host[60] = {};     // terminated by 0
};

/// thread: `noteWaiting` from any thread; all further calls from one thread at a time.
class RankWatch {
 public:
  using Clock = std::chrono::steady_clock;
  using Found = std::function<void(const std::string& sentence)>;

  /// `seconds`: a rank counts as silent if it has not worked for this time. requires: seconds > 0.
  RankWatch(int rank, int count, double seconds, Found found, Clock::time_point now = Clock::now());

  /// Records a wait for further ranks, which counts as work.
  void noteWaiting() { waiting_.fetch_add(1, std::memory_order_relaxed); }
  /// Returns the pulse to send if one is due. requires: called every few milliseconds.
  std::optional<Pulse> ownPulse(Clock::time_point now = Clock::now());
  /// Returns the final pulse of this rank. Afterwards `ownPulse` returns nothing.
  Pulse lastPulse();
  void onPulse(int rank, const Pulse& pulse, Clock::time_point now = Clock::now());
  /// True if every watched rank has sent its last pulse.
  bool allEnded() const;
  /// Returns the silent ranks in a sentence; empty if there are none.
  std::string silentRanks(Clock::time_point now = Clock::now()) const;
  const Found& found() const { return found_; }

 private:
  struct Watched {
    int rank = 0;
    Clock::time_point pulse_at;
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
  std::uint64_t work_ = 0, waits_ = 0;
  double processor_s_ = 0;
  std::atomic<std::uint64_t> waiting_ = 0;
};

}  // namespace kiln
