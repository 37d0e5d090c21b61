// A world of a single rank: receives the messages sent to itself and never waits.
#include "cluster/ranks.h"

#include <cstdlib>
#include <deque>
#include <map>
#include <mutex>
#include <utility>

#include "base/error.h"

namespace kiln {
namespace {

class LocalCounters : public SharedCounters {
 public:
  explicit LocalCounters(std::size_t count) : values_(count) {}
  std::uint64_t add(std::size_t counter, std::uint64_t amount) override {
    const std::scoped_lock lock(mutex_);
    return std::exchange(values_[counter], values_[counter] + amount);
  }

 private:
  std::mutex mutex_;
  std::vector<std::uint64_t> values_;
};

class OneRank : public Ranks {
 public:
  int rank() const override { return 0; }
  int count() const override { return 1; }
  void barrier() override {}
  std::unique_ptr<SharedCounters> makeCounters(std::size_t count) override {
    return std::make_unique<LocalCounters>(count);
  }
  void send(int /*to*/, int tag, std::vector<std::byte> bytes) override {
    const std::scoped_lock lock(mutex_);
    waiting_[tag].push_back(std::move(bytes));
  }
  RankMessage receive(int tag, std::optional<int> /*from*/) override {
    std::optional<RankMessage> message = poll(tag);
    if (!message) throw Error(ErrorCode::kUsage, "a rank waits for a message that nobody sends; this is a defect");
    return std::move(*message);
  }
  std::optional<RankMessage> poll(int tag) override {
    const std::scoped_lock lock(mutex_);
    std::deque<std::vector<std::byte>>& waiting = waiting_[tag];
    if (waiting.empty()) return std::nullopt;
    RankMessage out{0, std::move(waiting.front())};
    waiting.pop_front();
    return out;
  }
  std::vector<std::vector<std::byte>> gather(std::vector<std::byte> bytes) override {
    std::vector<std::vector<std::byte>> out;
    out.push_back(std::move(bytes));
    return out;
  }
  void broadcast(std::vector<std::byte>& /*bytes*/) override {}
  RankTraffic traffic() const override { return {}; }
  bool claimFailure() override { return true; }
  [[noreturn]] void abort(int exit_code) override { std::_Exit(exit_code); }

 private:
  std::mutex mutex_;
  std::map<int, std::deque<std::vector<std::byte>>> waiting_;
};

}  // namespace

std::unique_ptr<Ranks> oneRank() { return std::make_unique<OneRank>(); }

}  // namespace kiln
