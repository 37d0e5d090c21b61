#include "convert/pyramid/rank_exchange.h"

#include <algorithm>
#include <chrono>
#include <initializer_list>
#include <utility>

#include "base/byte_record.h"
#include "base/error.h"

namespace kiln {
namespace {

// One tag for all messages, so that messages of a rank arrive in order.
constexpr int kTag = 900;
// Interval between polls of an empty mailbox.
constexpr auto kPause = std::chrono::microseconds(300);

enum class Kind : std::uint8_t { kPiece, kTaken, kFinished, kResults };

std::span<const std::byte> bytesIn(const std::uint64_t& number) { return std::as_bytes(std::span(&number, 1)); }

std::vector<std::byte> letter(Kind kind, std::initializer_list<std::span<const std::byte>> contents) {
  std::size_t size = sizeof kind;
  for (const auto& content : contents) size += content.size();
  std::vector<std::byte> out(size);
  out[0] = static_cast<std::byte>(kind);
  auto at = out.begin() + sizeof kind;
  for (const auto& content : contents) at = std::copy(content.begin(), content.end(), at);
  return out;
}

FinishedBrick brickFrom(std::span<const std::byte> bytes, int from) {
  std::optional<FinishedBrick> brick = finishedBrickFrom(bytes);
  if (!brick)
    throw Error(ErrorCode::kDamaged, "a message of rank " + std::to_string(from) +
                                         " is not understood; start all ranks with the same version of Kiln");
  return *std::move(brick);
}

}  // namespace

RankExchange::RankExchange(Ranks& ranks, std::uint64_t most_bytes, Handlers handlers)
    : ranks_(ranks),
      most_bytes_(most_bytes),
      handlers_(std::move(handlers)),
      results_(static_cast<std::size_t>(ranks.count())),
      service_([this](const std::stop_token& stop) { serve(stop); }) {}

// Waits for `ready`, or rethrows a handler's failure.
template <class Ready>
void RankExchange::await(std::unique_lock<std::mutex>& lock, const Ready& ready) {
  changed_.wait(lock, [&] { return failure_ || ready(); });
  if (failure_) std::rethrow_exception(failure_);
}

void RankExchange::give(int to, const BrickKey& key, const BrickEntry& entry, const HalfBrick* piece) {
  const std::vector<std::byte> brick = bytesOf(FinishedBrick{key, entry, {}});
  std::vector<std::byte> bytes = letter(
      Kind::kPiece, {bytesIn(brick.size()), brick, piece != nullptr ? bytesOf(*piece) : std::vector<std::byte>()});
  {
    std::unique_lock lock(mutex_);
    await(lock, [&] { return given_bytes_ == 0 || given_bytes_ + bytes.size() <= most_bytes_; });
    given_bytes_ += bytes.size();
  }
  ranks_.send(to, kTag, std::move(bytes));
}

void RankExchange::sendFinished(const FinishedBrick& brick) {
  ranks_.send(0, kTag, letter(Kind::kFinished, {bytesOf(brick)}));
}

void RankExchange::throwIfFailed() {
  const std::scoped_lock lock(mutex_);
  if (failure_) std::rethrow_exception(failure_);
}

void RankExchange::sendResults(std::span<const std::byte> results) {
  ranks_.send(0, kTag, letter(Kind::kResults, {results}));
}

std::vector<std::vector<std::byte>> RankExchange::awaitResults() {
  std::unique_lock lock(mutex_);
  await(lock, [&] { return reported_ranks_ == ranks_.count(); });
  return results_;
}

void RankExchange::serve(const std::stop_token& stop) {
  try {
    while (!stop.stop_requested()) {
      if (const std::optional<RankMessage> message = ranks_.poll(kTag))
        handle(*message);
      else
        std::this_thread::sleep_for(kPause);
    }
  } catch (...) {
    const std::scoped_lock lock(mutex_);
    failure_ = std::current_exception();
  }
  changed_.notify_all();
}

void RankExchange::handle(const RankMessage& message) {
  ByteTaker taker{message.bytes};
  switch (taker.take<Kind>()) {
    case Kind::kPiece: {
      const FinishedBrick brick = brickFrom(taker.takeBytes(taker.take<std::uint64_t>()), message.from);
      std::optional<HalfBrick> piece;
      if (!taker.left.empty()) piece = partFrom(taker.left, "a message of rank " + std::to_string(message.from));
      handlers_.given(brick, std::move(piece));
      ranks_.send(message.from, kTag, letter(Kind::kTaken, {bytesIn(message.bytes.size())}));
      return;
    }
    case Kind::kTaken: {
      const std::scoped_lock lock(mutex_);
      given_bytes_ -= taker.take<std::uint64_t>();
      break;
    }
    case Kind::kFinished:
      handlers_.finished(brickFrom(taker.left, message.from));
      return;
    case Kind::kResults: {
      const std::scoped_lock lock(mutex_);
      results_[static_cast<std::size_t>(message.from)].assign(taker.left.begin(), taker.left.end());
      ++reported_ranks_;
      break;
    }
  }
  changed_.notify_all();
}

}  // namespace kiln
