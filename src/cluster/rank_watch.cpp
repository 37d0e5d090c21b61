#include "cluster/rank_watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <utility>

#include "base/duration_text.h"
#include "base/process.h"
#include "base/work_count.h"

namespace kiln {
namespace {

// Longest gap between two calls of the service loop. A longer gap means that the process itself was stopped, perhaps
// with all ranks. unit: seconds.
constexpr double kOwnGap_s = 2;
// Least share of a core for a rank to count as computing. Threads polling for messages take some hundredths.
constexpr double kComputingShare = 0.15;
// All ranks watch rank 0. Each rank waits this much longer than the rank before, so a single rank reports. unit:
// seconds.
constexpr double kTurn_s = 0.5;

double seconds(std::chrono::steady_clock::duration d) { return std::chrono::duration<double>(d).count(); }

}  // namespace

RankWatch::RankWatch(int rank, int count, double seconds, Found found, Clock::time_point now)
    : rank_(rank),
      seconds_(seconds),
      interval_s_(std::min(1.0, seconds / 4)),
      found_(std::move(found)),
      host_(hostName()),
      called_(now),
      sent_(now),
      worked_(now) {
  for (int other = 0; other < (rank == 0 ? count : 1); ++other)
    if (other != rank) watched_.push_back({other, now, 0, false, "an unknown host"});
}

bool RankWatch::worked(double interval_s) {
  const std::uint64_t work = workCount().load(std::memory_order_relaxed),
                      waits = waiting_.load(std::memory_order_relaxed);
  const double processor_s = static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
  const bool computed = processor_s - processor_s_ >= kComputingShare * interval_s;
  const bool out = std::exchange(work_, work) != work || std::exchange(waits_, waits) != waits || computed;
  processor_s_ = processor_s;
  return out;
}

std::optional<Pulse> RankWatch::ownPulse(Clock::time_point now) {
  if (const Clock::duration gap = now - std::exchange(called_, now); seconds(gap) > kOwnGap_s) {
    worked_ += gap;
    for (Watched& other : watched_) other.pulse_at += gap;
  }
  const double since_s = seconds(now - sent_);
  if (ended_ || (begun_ && since_s < interval_s_)) return std::nullopt;
  if (worked(since_s) || !begun_) worked_ = now;
  begun_ = true;
  sent_ = now;
  Pulse out;
  out.idle_s = seconds(now - worked_);
  std::strncpy(out.host, host_.c_str(), sizeof out.host - 1);
  return out;
}

Pulse RankWatch::lastPulse() {
  ended_ = true;
  Pulse out;
  out.last = 1;
  return out;
}

void RankWatch::onPulse(int rank, const Pulse& pulse, Clock::time_point now) {
  for (Watched& other : watched_) {
    if (other.rank != rank) continue;
    other.pulse_at = now;
    other.idle_s = pulse.idle_s;
    other.ended = pulse.last != 0;
    if (pulse.host[0] != 0) other.host = pulse.host;
  }
}

bool RankWatch::allEnded() const {
  return std::all_of(watched_.begin(), watched_.end(), [](const Watched& other) { return other.ended; });
}

std::string RankWatch::silentRanks(Clock::time_point now) const {
  std::string out;
  for (const Watched& other : watched_) {
    const double unheard_s = seconds(now - other.pulse_at), silent_s = unheard_s + other.idle_s;
    if (other.ended || silent_s < seconds_ + kTurn_s * rank_) continue;
    const char* const what = unheard_s > seconds_ / 2 && unheard_s > 2 * interval_s_
                                 ? "has not answered for {}; it is stopped, or its machine or network is gone"
                                 : "has not read, written or computed for {}; its disk does not answer";
    out += fmt::format("{}rank {} on {} ", out.empty() ? "" : "; ", other.rank, other.host) +
           fmt::format(fmt::runtime(what), roughDurationText(silent_s));
  }
  return out.empty() ? out : out + fmt::format("; --rank-timeout {:g} ends the run", seconds_);
}

}  // namespace kiln
