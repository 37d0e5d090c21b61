// The processes (ranks) of a command. mpirun starts the ranks; MPI carries messages and detects a dead rank. Without
// mpirun there is a single rank, and all code runs unchanged. Only a module loaded by ranks of mpirun uses MPI
// (`mpiRanks`).
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cluster/call_watch.h"

namespace kiln {

/// Traffic of a rank so far.
struct RankTraffic {
  std::uint64_t sent_bytes = 0, received_bytes = 0;
  double waited_s = 0;  // for messages and at barriers
};

struct RankMessage {
  int from = 0;
  std::vector<std::byte> bytes;
};

/// Counters shared by all ranks, initially 0.
class SharedCounters {
 public:
  virtual ~SharedCounters() = default;
  /// Adds to a counter and returns its previous value, so each number is handed out once. thread: safe.
  virtual std::uint64_t add(std::size_t counter, std::uint64_t amount) = 0;
};

/// thread: send, receive, poll, traffic and SharedCounters::add from any thread; collective calls from a single thread
/// at a time. All ranks make collective calls in equal order. A failing rank must call `abort`, because all ranks would
/// wait for it.
class Ranks {
 public:
  virtual ~Ranks() = default;
  /// Number of this rank, from 0 on.
  virtual int rank() const = 0;
  virtual int count() const = 0;
  /// True for rank 0, which reports progress and writes shared results.
  bool first() const { return rank() == 0; }
  bool alone() const { return count() == 1; }

  /// Collective. Returns after all ranks have called.
  virtual void barrier() = 0;
  /// Collective. Makes counters that start at 0.
  virtual std::unique_ptr<SharedCounters> makeCounters(std::size_t count) = 0;

  /// Sends `bytes` without waiting; a message arrives whole. Messages of one tag between two ranks arrive in order.
  /// requires: 0 <= to < count(); 0 <= tag < kTags; less than 2 GiB.
  virtual void send(int to, int tag, std::vector<std::byte> bytes) = 0;
  /// Waits for the next message of a rank, or of any rank.
  virtual RankMessage receive(int tag, std::optional<int> from = std::nullopt) = 0;
  /// Returns a pending message of any rank; nothing if there is none.
  virtual std::optional<RankMessage> poll(int tag) = 0;

  /// Collective. Returns on rank 0 the bytes of each rank, in the order of ranks; nothing on all further ranks.
  virtual std::vector<std::vector<std::byte>> gather(std::vector<std::byte> bytes) = 0;
  /// Collective. Copies rank 0's bytes to all ranks.
  virtual void broadcast(std::vector<std::byte>& bytes) = 0;

  virtual RankTraffic traffic() const = 0;

  /// Starts a watch that calls found(sentence) after another rank has not answered, read, written, computed or waited
  /// for other ranks for `seconds`. The sentence names all such ranks and hosts. Does nothing without messages
  /// between processes. thread: `found` is called by an internal thread and ends the process.
  virtual void watch(double /*seconds*/, std::function<void(const std::string& sentence)> /*found*/) {}
  /// True for the first failing rank, the only rank to print an error.
  virtual bool claimFailure() = 0;
  /// Ends all ranks at once.
  [[noreturn]] virtual void abort(int exit_code) = 0;

  static constexpr int kTags = 1024;
};

/// A world of a single rank, the process itself.
std::unique_ptr<Ranks> oneRank();

/// The ranks started by mpirun (or srun). `limit`: on the start and the end of all ranks, and on any call that keeps a
/// thread within MPI; a rank stopped there answers no watch. requires: called once per process. throws: Error
/// kUnsupported, with a remedy, if Kiln was built without MPI or the module cannot be loaded.
std::unique_ptr<Ranks> mpiRanks(const CallLimit& limit);

}  // namespace kiln
