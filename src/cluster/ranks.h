// The processes that work together on one command, in Kiln's own terms. mpirun starts them, the message-passing library
// carries what they say to one another and notices one that dies; without it there is a world of one rank, and the same
// code runs through. The library itself is behind `mpiRanks`, in a module that only ranks of mpirun load.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace kiln {

/// What a rank has sent, received and waited for so far.
struct RankTraffic {
  std::uint64_t sent_bytes = 0, received_bytes = 0;
  double waited_s = 0;  // for messages and for the others at a barrier
};

struct RankMessage {
  int from = 0;
  std::vector<std::byte> bytes;
};

/// Numbers that all ranks share, each 0 at first.
class SharedCounters {
 public:
  virtual ~SharedCounters() = default;
  /// Adds to a number and returns what it was before: handed out like this, each number is one rank's. thread: safe.
  virtual std::uint64_t add(std::size_t counter, std::uint64_t amount) = 0;
};

/// thread: what one rank asks for alone (send, receive, poll, counters' add, traffic) from any thread; what all ranks
/// do together ("collective": in the same order on each) from one thread at a time. A rank that fails calls `abort`:
/// the others would wait for it.
class Ranks {
 public:
  virtual ~Ranks() = default;
  /// From 0 on.
  virtual int rank() const = 0;
  virtual int count() const = 0;
  /// The one that speaks for all: progress, reports, what is written once.
  bool first() const { return rank() == 0; }
  bool alone() const { return count() == 1; }

  /// Collective. Returns when all ranks have called it.
  virtual void barrier() = 0;
  /// Collective.
  virtual std::unique_ptr<SharedCounters> makeCounters(std::size_t count) = 0;

  /// Hands `bytes` over and returns at once; they arrive whole. Messages of one tag from one rank to another arrive in
  /// their order. requires: another rank or this one; 0 <= tag < kTags; less than 2 GiB.
  virtual void send(int to, int tag, std::vector<std::byte> bytes) = 0;
  /// Waits for the next message of a rank, or of any.
  virtual RankMessage receive(int tag, std::optional<int> from = std::nullopt) = 0;
  /// The next message of any rank, if one is there.
  virtual std::optional<RankMessage> poll(int tag) = 0;

  /// Collective. What each rank gives, by rank, on the first; nothing on the others.
  virtual std::vector<std::vector<std::byte>> gather(std::vector<std::byte> bytes) = 0;
  /// Collective. What the first rank has, on all.
  virtual void broadcast(std::vector<std::byte>& bytes) = 0;

  virtual RankTraffic traffic() const = 0;

  /// From here on, calls found(sentence) once another rank has for `seconds` neither answered, nor read, written,
  /// computed or waited for other ranks. The sentence names all such ranks and their hosts. Does nothing in a world
  /// without messages between processes. thread: `found` is called by a thread of the ranks' own; it ends the process.
  virtual void watch(double /*seconds*/, std::function<void(const std::string& sentence)> /*found*/) {}
  /// Whether this rank is the first to fail, and so the one whose sentence is shown.
  virtual bool claimFailure() = 0;
  /// Ends all ranks at once.
  [[noreturn]] virtual void abort(int exit_code) = 0;

  static constexpr int kTags = 1024;
};

/// This process alone.
std::unique_ptr<Ranks> oneRank();

/// The ranks that mpirun (or srun) started this process with. Once a process. throws: Error kUnsupported where Kiln was
/// built without MPI or its module cannot be loaded, saying what to do.
std::unique_ptr<Ranks> mpiRanks();

}  // namespace kiln
