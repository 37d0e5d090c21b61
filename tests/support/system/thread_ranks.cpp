#include "support/system/thread_ranks.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

namespace kiln::test {
namespace {

struct Ended : std::runtime_error {
  Ended() : std::runtime_error("another rank has ended the job") {}
};

struct World {
  explicit World(int ranks) : count(ranks) {}

  // Requires the lock.
  template <class Ready>
  void await(std::unique_lock<std::mutex>& lock, const Ready& ready) {
    changed.wait(lock, [&] { return ended || ready(); });
    if (ended) throw Ended();
  }
  void end(std::exception_ptr failure) {
    const std::scoped_lock lock(mutex);
    if (!std::exchange(ended, true)) first_failure = std::move(failure);
    changed.notify_all();
  }

  const int count;
  std::mutex mutex;
  std::condition_variable changed;
  std::map<std::pair<int, int>, std::deque<RankMessage>> mail;  // messages by receiver and tag
  std::vector<std::uint64_t> numbers;
  int arrived = 0;
  std::uint64_t barriers = 0;
  std::vector<std::vector<std::byte>> gathered;
  std::vector<std::byte> sent_to_all;
  bool ended = false;
  std::exception_ptr first_failure;
};

class WorldCounters : public SharedCounters {
 public:
  WorldCounters(World& world, std::size_t first) : world_(world), first_(first) {}
  std::uint64_t add(std::size_t counter, std::uint64_t amount) override {
    const std::scoped_lock lock(world_.mutex);
    std::uint64_t& number = world_.numbers[first_ + counter];
    return std::exchange(number, number + amount);
  }

 private:
  World& world_;
  const std::size_t first_;
};

class ThreadRanks : public Ranks {
 public:
  ThreadRanks(World& world, int rank) : world_(world), rank_(rank) {}
  int rank() const override { return rank_; }
  int count() const override { return world_.count; }

  void barrier() override {
    std::unique_lock lock(world_.mutex);
    const std::uint64_t before = world_.barriers;
    if (++world_.arrived == world_.count) {
      world_.arrived = 0;
      ++world_.barriers;
      world_.changed.notify_all();
    }
    world_.await(lock, [&] { return world_.barriers != before; });
  }

  std::unique_ptr<SharedCounters> makeCounters(std::size_t count) override {
    barrier();
    if (first()) world_.numbers.resize(world_.numbers.size() + count);
    barrier();
    return std::make_unique<WorldCounters>(world_, world_.numbers.size() - count);
  }

  void send(int to, int tag, std::vector<std::byte> bytes) override {
    const std::scoped_lock lock(world_.mutex);
    traffic_.sent_bytes += bytes.size();
    world_.mail[{to, tag}].push_back({rank_, std::move(bytes)});
    world_.changed.notify_all();
  }
  RankMessage receive(int tag, std::optional<int> /*from*/) override {
    std::unique_lock lock(world_.mutex);
    std::deque<RankMessage>& mail = world_.mail[{rank_, tag}];
    world_.await(lock, [&] { return !mail.empty(); });
    return taken(mail);
  }
  std::optional<RankMessage> poll(int tag) override {
    const std::scoped_lock lock(world_.mutex);
    if (world_.ended) throw Ended();
    std::deque<RankMessage>& mail = world_.mail[{rank_, tag}];
    if (mail.empty()) return std::nullopt;
    return taken(mail);
  }

  std::vector<std::vector<std::byte>> gather(std::vector<std::byte> bytes) override {
    barrier();
    if (first()) world_.gathered.assign(static_cast<std::size_t>(world_.count), {});
    barrier();
    {
      const std::scoped_lock lock(world_.mutex);
      world_.gathered[static_cast<std::size_t>(rank_)] = std::move(bytes);
    }
    barrier();
    return first() ? world_.gathered : std::vector<std::vector<std::byte>>();
  }
  void broadcast(std::vector<std::byte>& bytes) override {
    if (first()) world_.sent_to_all = bytes;
    barrier();
    bytes = world_.sent_to_all;
    barrier();
  }

  RankTraffic traffic() const override {
    const std::scoped_lock lock(world_.mutex);
    return traffic_;
  }
  bool claimFailure() override { throw std::logic_error("a test's ranks fail by throwing"); }
  [[noreturn]] void abort(int /*exit_code*/) override { throw std::logic_error("a test's ranks fail by throwing"); }

 private:
  static RankMessage taken(std::deque<RankMessage>& mail) {
    RankMessage out = std::move(mail.front());
    mail.pop_front();
    return out;
  }

  World& world_;
  const int rank_;
  RankTraffic traffic_;
};

}  // namespace

void runRanks(int count, const std::function<void(Ranks&)>& body) {
  World world(count);
  std::vector<std::jthread> threads;
  for (int rank = 0; rank < count; ++rank) {
    threads.emplace_back([&world, &body, rank] {
      ThreadRanks ranks(world, rank);
      try {
        body(ranks);
      } catch (...) {
        world.end(std::current_exception());
      }
    });
  }
  threads.clear();
  if (world.first_failure) std::rethrow_exception(world.first_failure);
}

}  // namespace kiln::test
