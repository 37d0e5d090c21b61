// Ranks over MPI (standard 3.1; written against Open MPI 4.1).
// A mutex serialises all MPI calls. A wait tests, sleeps briefly and tests again, so a waiting rank leaves its core
// to working ranks. The sleep matters with more ranks than cores.
// A service thread calls MPI every millisecond. Over TCP, messages and counters of rank 0 make progress only while the
// target calls MPI, and a drawing rank calls nothing.
#define OMPI_SKIP_MPICXX 1
#include <mpi.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <exception>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "base/elapsed.h"
#include "base/error.h"
#include "cluster/call_watch.h"
#include "cluster/rank_watch.h"
#include "cluster/ranks.h"

namespace kiln {
namespace {

using Clock = std::chrono::steady_clock;

// Internal tags of collectives, counters and pulses, above the tags of Kiln's messages.
constexpr int kGatherTag = Ranks::kTags, kAddTag = kGatherTag + 1, kAddedTag = kGatherTag + 2,
              kPulseTag = kGatherTag + 3;
// Most bytes of one MPI call in a collective: MPI counts in int.
constexpr std::size_t kLargestCall = std::size_t{1} << 30;

struct CounterRequest {
  std::uint64_t set, counter, amount;
};

class MpiRanks : public Ranks {
 public:
  explicit MpiRanks(CallLimit limit) : limit_(std::move(limit)) {
    const CallWatch starting(limit_);
    int level = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &level);
    if (level < MPI_THREAD_SERIALIZED)
      throw Error(ErrorCode::kUnsupported, "this MPI may not be called from more than one thread; use another build");
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
    one_machine_ = ranksOfThisMachine() == count_;
    service_ = std::jthread([this](const std::stop_token& stop) { serve(stop); });
    failures_ = makeCounters(1);
  }

  ~MpiRanks() override {
    failures_.reset();
    waitUntil([this] { return outgoingDone(); });
    endPulses();
    const CallWatch ending(limit_);
    barrier();
    service_ = {};
    MPI_Finalize();
  }

  int rank() const override { return rank_; }
  int count() const override { return count_; }

  void barrier() override {
    MPI_Request request;
    locked([&] { MPI_Ibarrier(MPI_COMM_WORLD, &request); });
    wait(request);
  }

  void send(int to, int tag, std::vector<std::byte> bytes) override {
    requireSize(bytes.size());
    locked([&] {
      traffic_.sent_bytes += bytes.size();
      Outgoing& out = outgoing_.emplace_back();
      out.bytes = std::move(bytes);
      MPI_Isend(out.bytes.data(), static_cast<int>(out.bytes.size()), MPI_BYTE, to, tag, MPI_COMM_WORLD, &out.request);
    });
  }

  RankMessage receive(int tag, std::optional<int> from) override {
    std::optional<Incoming> incoming;
    waitUntil([&] { return (incoming = begin(tag, from)).has_value(); });
    return finish(std::move(*incoming));
  }

  std::optional<RankMessage> poll(int tag) override {
    std::optional<Incoming> incoming;
    locked([&] { incoming = begin(tag, std::nullopt); });
    noteWaiting();
    if (!incoming) return std::nullopt;
    return finish(std::move(*incoming));
  }

  std::vector<std::vector<std::byte>> gather(std::vector<std::byte> bytes) override {
    std::vector<std::vector<std::byte>> out;
    if (!first()) {
      send(0, kGatherTag, std::move(bytes));
      return out;
    }
    out.push_back(std::move(bytes));
    for (int from = 1; from < count_; ++from) out.push_back(receive(kGatherTag, from).bytes);
    return out;
  }

  void broadcast(std::vector<std::byte>& bytes) override {
    std::uint64_t size = bytes.size();
    broadcastBytes(std::as_writable_bytes(std::span(&size, 1)));
    bytes.resize(size);
    broadcastBytes(bytes);
  }

  std::unique_ptr<SharedCounters> makeCounters(std::size_t count) override;

  RankTraffic traffic() const override {
    const std::scoped_lock lock(mutex_);
    return traffic_;
  }

  void watch(double seconds, std::function<void(const std::string&)> found) override {
    locked([&] { watch_.emplace(rank_, count_, seconds, std::move(found)); });
  }

  bool claimFailure() override {
    // If rank 0 has died there is no answer; mpirun then ends this rank.
    return failures_->add(0, 1) == 0;
  }

  [[noreturn]] void abort(int exit_code) override {
    MPI_Abort(MPI_COMM_WORLD, exit_code);
    std::_Exit(exit_code);
  }

 private:
  friend class WindowCounters;
  friend class MasterCounters;
  struct Outgoing {
    std::vector<std::byte> bytes;
    MPI_Request request = MPI_REQUEST_NULL;
  };
  struct Incoming {
    RankMessage message;
    MPI_Request request = MPI_REQUEST_NULL;
  };

  static void requireSize(std::size_t bytes) {
    if (bytes > static_cast<std::size_t>(INT32_MAX))
      throw Error(ErrorCode::kUsage, "a message of 2 GiB or more between ranks; draw a smaller image, or more tiles");
  }

  template <class Body>
  void locked(const Body& body) {
    const std::scoped_lock lock(mutex_);
    body();
  }

  // As locked, for the service thread. A call of another thread that waits within MPI for a stopped rank keeps the lock
  // for ever: Open MPI's counters on one machine share a lock. No pulse would reveal that rank.
  template <class Body>
  void lockedWithinLimit(const Body& body) {
    constexpr std::chrono::milliseconds kStep{20};
    std::unique_lock lock(mutex_, std::defer_lock);
    for (auto waited = kStep; !lock.try_lock_for(kStep); waited += kStep) {
      if (limit_.seconds > 0 && waited > std::chrono::duration<double>(limit_.seconds)) limit_.found();
    }
    body();
  }

  // Tests `done` 20 times without sleeping, then with growing sleeps of up to half a millisecond.
  template <class Done>
  void waitUntil(const Done& done) {
    const Clock::time_point begin = Clock::now();
    bool is_done = false;
    auto sleep = std::chrono::microseconds(20);
    for (int tries = 0;; ++tries) {
      locked([&] { is_done = done(); });
      if (is_done) break;
      noteWaiting();
      if (tries < 20) {
        std::this_thread::yield();
        continue;
      }
      std::this_thread::sleep_for(sleep);
      sleep = std::min(2 * sleep, std::chrono::microseconds(500));
    }
    locked([&] { traffic_.waited_s += secondsSince(begin); });
  }

  void wait(MPI_Request& request) {
    waitUntil([&] {
      int done = 0;
      MPI_Test(&request, &done, MPI_STATUS_IGNORE);
      return done != 0;
    });
  }

  // begin and outgoingDone require the lock.
  // Receives by matched probe, so no other thread takes the message.
  std::optional<Incoming> begin(int tag, std::optional<int> from) {
    int there = 0;
    MPI_Message handle;
    MPI_Status status;
    MPI_Improbe(from.value_or(MPI_ANY_SOURCE), tag, MPI_COMM_WORLD, &there, &handle, &status);
    if (there == 0) return std::nullopt;
    int bytes = 0;
    MPI_Get_count(&status, MPI_BYTE, &bytes);
    Incoming out;
    out.message.from = status.MPI_SOURCE;
    out.message.bytes.resize(static_cast<std::size_t>(bytes));
    MPI_Imrecv(out.message.bytes.data(), bytes, MPI_BYTE, &handle, &out.request);
    traffic_.received_bytes += out.message.bytes.size();
    return out;
  }

  bool outgoingDone() {
    outgoing_.remove_if([](Outgoing& out) {
      int done = 0;
      MPI_Test(&out.request, &done, MPI_STATUS_IGNORE);
      return done != 0;
    });
    return outgoing_.empty();
  }

  RankMessage finish(Incoming incoming) {
    wait(incoming.request);
    return std::move(incoming.message);
  }

  void broadcastBytes(std::span<std::byte> bytes) {
    for (std::size_t i = 0; i < bytes.size(); i += kLargestCall) {
      const std::span<std::byte> some = bytes.subspan(i, std::min(kLargestCall, bytes.size() - i));
      MPI_Request request;
      locked([&] {
        MPI_Ibcast(some.data(), static_cast<int>(some.size()), MPI_BYTE, 0, MPI_COMM_WORLD, &request);
        (first() ? traffic_.sent_bytes : traffic_.received_bytes) += some.size();
      });
      wait(request);
    }
  }

  static int ranksOfThisMachine() {
    MPI_Comm machine;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &machine);
    int out = 1;
    MPI_Comm_size(machine, &out);
    MPI_Comm_free(&machine);
    // All machines use the least number, so all ranks choose an equal kind of counters.
    MPI_Allreduce(MPI_IN_PLACE, &out, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
    return out;
  }

  // Adds to a counter on rank 0 and returns its previous value. requires: the lock.
  std::uint64_t addToCounter(const CounterRequest& request) {
    std::uint64_t& value = sets_[request.set][request.counter];
    return std::exchange(value, value + request.amount);
  }

  // Serves all pending counter requests. requires: the lock. The messages are small enough for MPI to send without
  // waiting.
  void serveCounters() {
    int there = 0;
    MPI_Status status;
    while (MPI_Iprobe(MPI_ANY_SOURCE, kAddTag, MPI_COMM_WORLD, &there, &status), there != 0) {
      CounterRequest request;
      MPI_Recv(&request, sizeof(request), MPI_BYTE, status.MPI_SOURCE, kAddTag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
      const std::uint64_t before = addToCounter(request);
      MPI_Send(&before, sizeof(before), MPI_BYTE, status.MPI_SOURCE, kAddedTag, MPI_COMM_WORLD);
    }
  }

  void serve(const std::stop_token& stop) {
    while (!stop.stop_requested()) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      std::string silent;
      lockedWithinLimit([&] {
        serveCounters();
        outgoingDone();
        if (!watch_) return;
        if (const auto pulse = watch_->ownPulse()) sendPulse(*pulse);
        receivePulses();
        silent = watch_->silentRanks();
      });
      // Without the lock: the handler makes calls of its own.
      if (!silent.empty()) watch_->found()(silent);
    }
  }

  // Sends a pulse: every rank to rank 0, rank 0 to all ranks. requires: the lock.
  void sendPulse(const Pulse& pulse) {
    for (int to = first() ? 1 : 0; to < (first() ? count_ : 1); ++to) {
      Outgoing& out = outgoing_.emplace_back();
      const auto bytes = std::as_bytes(std::span(&pulse, 1));
      out.bytes.assign(bytes.begin(), bytes.end());
      MPI_Isend(out.bytes.data(), static_cast<int>(out.bytes.size()), MPI_BYTE, to, kPulseTag, MPI_COMM_WORLD,
                &out.request);
    }
  }

  // Receives all pending pulses. requires: the lock. Pulses are small enough for MPI to send without waiting.
  void receivePulses() {
    int there = 0;
    MPI_Status status;
    while (MPI_Iprobe(MPI_ANY_SOURCE, kPulseTag, MPI_COMM_WORLD, &there, &status), there != 0) {
      Pulse pulse;
      MPI_Recv(&pulse, sizeof(pulse), MPI_BYTE, status.MPI_SOURCE, kPulseTag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
      watch_->onPulse(status.MPI_SOURCE, pulse);
    }
  }

  // Collective in effect: when the function returns no pulse is in flight, so MPI may be finalised.
  void endPulses() {
    if (!watch_) return;
    locked([&] { sendPulse(watch_->lastPulse()); });
    waitUntil([this] {
      receivePulses();
      return watch_->allEnded() && outgoingDone();
    });
  }

  // Records a wait of the thread for collective calls: a waiting rank is not hung.
  void noteWaiting() {
    if (std::this_thread::get_id() == main_ && watch_) watch_->noteWaiting();
  }

  const CallLimit limit_;  // on calls of MPI that wait for other ranks
  int rank_ = 0, count_ = 1;
  mutable std::timed_mutex mutex_;  // guards MPI and all members below
  RankTraffic traffic_;
  std::list<Outgoing> outgoing_;
  bool one_machine_ = true;
  std::uint64_t next_set_ = 0;
  std::map<std::uint64_t, std::vector<std::uint64_t>> sets_;  // MasterCounters, on rank 0
  std::unique_ptr<SharedCounters> failures_;
  std::optional<RankWatch> watch_;
  const std::thread::id main_ = std::this_thread::get_id();
  std::jthread service_;
};

// True while an error ends the process: the error ends all ranks, so waiting is pointless.
bool endsByError() { return std::uncaught_exceptions() > 0; }

// Counters of ranks on a single machine: one-sided access to a window in rank 0's memory; an addition is an atomic
// instruction.
class WindowCounters : public SharedCounters {
 public:
  WindowCounters(MpiRanks& ranks, std::size_t count) : ranks_(ranks) {
    // MPI_Win_allocate blocks with the lock held until all ranks have called it, and no pulse is sent meanwhile. The
    // barrier keeps this time short.
    ranks_.barrier();
    const std::scoped_lock lock(ranks.mutex_);
    const std::size_t bytes = ranks.first() ? count * sizeof(std::uint64_t) : 0;
    void* memory = nullptr;
    MPI_Win_allocate(static_cast<MPI_Aint>(bytes), sizeof(std::uint64_t), MPI_INFO_NULL, MPI_COMM_WORLD, &memory,
                     &window_);
    if (bytes > 0) std::memset(memory, 0, bytes);
    MPI_Win_lock_all(0, window_);
    MPI_Win_sync(window_);
    MPI_Barrier(MPI_COMM_WORLD);
  }
  ~WindowCounters() override {
    if (endsByError()) return;
    // Freeing is collective and waits without sleeping; the barrier before it sleeps.
    ranks_.barrier();
    const std::scoped_lock lock(ranks_.mutex_);
    MPI_Win_unlock_all(window_);
    MPI_Win_free(&window_);
  }

  std::uint64_t add(std::size_t counter, std::uint64_t amount) override {
    const std::scoped_lock lock(ranks_.mutex_);
    std::uint64_t before = 0;
    MPI_Fetch_and_op(&amount, &before, MPI_UINT64_T, 0, static_cast<MPI_Aint>(counter), MPI_SUM, window_);
    MPI_Win_flush(0, window_);
    return before;
  }

 private:
  MpiRanks& ranks_;
  MPI_Win window_ = MPI_WIN_NULL;
};

// Counters of ranks on several machines: rank 0's service thread adds. Open MPI 4.1 has no window over TCP by default,
// and its optional window answers in 5 ms.
class MasterCounters : public SharedCounters {
 public:
  MasterCounters(MpiRanks& ranks, std::size_t count) : ranks_(ranks) {
    {
      const std::scoped_lock lock(ranks.mutex_);
      set_ = ranks.next_set_++;
      if (ranks.first()) ranks.sets_[set_].resize(count);
    }
    ranks.barrier();
  }
  ~MasterCounters() override {
    if (endsByError()) return;
    ranks_.barrier();
    const std::scoped_lock lock(ranks_.mutex_);
    ranks_.sets_.erase(set_);
  }

  std::uint64_t add(std::size_t counter, std::uint64_t amount) override {
    const CounterRequest request{set_, counter, amount};
    if (ranks_.first()) {
      const std::scoped_lock lock(ranks_.mutex_);
      return ranks_.addToCounter(request);
    }
    // A single request per rank at a time, so the next answer belongs to the request.
    const std::scoped_lock lock(request_mutex_);
    std::vector<std::byte> bytes(sizeof(request));
    std::memcpy(bytes.data(), &request, sizeof(request));
    ranks_.send(0, kAddTag, std::move(bytes));
    std::uint64_t before = 0;
    std::memcpy(&before, ranks_.receive(kAddedTag, 0).bytes.data(), sizeof(before));
    return before;
  }

 private:
  MpiRanks& ranks_;
  std::uint64_t set_ = 0;
  std::mutex request_mutex_;
};

std::unique_ptr<SharedCounters> MpiRanks::makeCounters(std::size_t count) {
  if (one_machine_) return std::make_unique<WindowCounters>(*this, count);
  return std::make_unique<MasterCounters>(*this, count);
}

}  // namespace
}  // namespace kiln

extern "C" __attribute__((visibility("default"))) kiln::Ranks* kilnMakeMpiRanks(const kiln::CallLimit& limit) {
  return new kiln::MpiRanks(limit);
}
