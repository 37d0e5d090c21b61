#include "ranks/shared_reads.h"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <utility>

#include "base/thread/parallel.h"
#include "base/thread/profile_scope.h"
#include "base/thread/trace.h"
#include "store/brick_index.h"
#include "store/store_writer.h"

namespace kiln {
namespace {

// Tag of all messages; frames and conversions have other tags.
constexpr int kReadsTag = 800;
// Polling interval for messages: while an answer is expected, and otherwise.
constexpr std::chrono::microseconds kShortPause(100), kLongPause(1000);
// Server threads; and least and most memory for files being read or sent. unit: threads; largest files.
constexpr unsigned kMostServers = 4;
constexpr std::uint64_t kLeastServed = 2, kMostServed = 8;
// A served file is in memory twice: as read, and in its message.
constexpr std::uint64_t kCopies = 2;
// MPI counts bytes of a message in an int.
constexpr std::uint64_t kLargestSent = std::uint64_t{1} << 30;

}  // namespace

// The last bytes of each message, behind the bytes of a file if the message carries a file.
struct SharedReads::Trailer {
  Kind kind = Kind::kRequest;
  std::int32_t from_disk = 0;
  std::uint64_t number = 0;  // of the request; in kTaken the file's size in bytes
  Hash128 store;             // checksum of the store's index
  BrickKey key;
};

struct SharedReads::Request {
  int from = 0;
  std::uint64_t number = 0;
  Hash128 store;
  BrickKey key;
};

SharedReads::SharedReads(Ranks& ranks) : ranks_(ranks) {
  threads_.emplace_back([this](const std::stop_token& stop) { receive(stop); });
  const unsigned servers = std::clamp(ThreadLimit::active(), 1u, kMostServers);
  for (unsigned i = 0; i < servers; ++i) threads_.emplace_back([this](const std::stop_token& stop) { serve(stop); });
}

SharedReads::~SharedReads() { abandon(); }

std::uint64_t SharedReads::largestFileOf(const std::vector<const StoreReader*>& stores) {
  std::uint64_t out = 0;
  for (const StoreReader* const store : stores) out = std::max(out, store->largestFileBytes());
  return out;
}

std::uint64_t SharedReads::shareOf(std::uint64_t budget_bytes, std::uint64_t left_bytes, std::uint64_t largest_bytes) {
  const std::uint64_t share = std::min(budget_bytes / 8, left_bytes / 4);
  return share >= 2 * kLeastServed * largest_bytes ? share : 0;
}

void SharedReads::open(const std::vector<const StoreReader*>& stores, std::uint64_t bytes) {
  const std::uint64_t largest = largestFileOf(stores);
  const Lock lock(mutex_);
  stores_ = stores;
  largest_serving_bytes_ = std::clamp(bytes / 2, kLeastServed * largest, kMostServed * largest);
  files_ = std::make_unique<EncodedBricks>(bytes - largest_serving_bytes_);
}

void SharedReads::close() {
  Lock lock(mutex_);
  closing_ = true;
  changed_.wait(lock, [&] { return serving_ == 0; });
  closing_ = false;
  stores_.clear();
  files_.reset();
}

void SharedReads::settle(const std::vector<BrickHome>& homes) {
  homes_.clear();
  for (const BrickHome& home : homes) homes_[home.key] = home;
}

BrickHome SharedReads::homeOf(const StoreReader& store, const BrickKey& key) const {
  if (const auto home = homes_.find(key); home != homes_.end() && &store == stores_.front()) return home->second;
  const std::array<std::int32_t, 4> place = {key.level, key.brick.x, key.brick.y, key.brick.z};
  const Hash128 hash = hashOf(std::as_bytes(std::span(place)));
  std::uint64_t number = 0, of_store = 0;
  std::memcpy(&number, hash.bytes.data(), sizeof number);
  std::memcpy(&of_store, store.manifest().index_checksum.bytes.data(), sizeof of_store);
  return {key, static_cast<std::int32_t>((number ^ of_store) % static_cast<std::uint64_t>(ranks_.count())),
          ranks_.count() - 1};
}

BrickFile SharedReads::fetch(const StoreReader& store, const BrickKey& key) {
  const BrickHome home = homeOf(store, key);
  if (home.rank == ranks_.rank()) return readKept(store, key, home.others > 0);
  if (std::optional<BrickFile> file = requestFrom(home.rank, store, key)) return *std::move(file);
  return readHere(store, key);
}

SuppliedBrick SharedReads::supply(const StoredBrick& brick) {
  const StoreReader& store = *stores_[static_cast<std::size_t>(brick.store)];
  const BrickFile file = fetch(store, brick.key);
  return {store.decode(brick.key, *file.bytes), file.from_disk};
}

BrickFile SharedReads::readHere(const StoreReader& store, const BrickKey& key) {
  BrickFile out{std::make_shared<const std::vector<std::byte>>(store.readFile(key)), true};
  countRead(*out.bytes);
  return out;
}

const StoreReader* SharedReads::openedStore(const Hash128& index) const {
  if (closing_) return nullptr;
  const auto store = std::find_if(stores_.begin(), stores_.end(),
                                  [&](const StoreReader* one) { return one->manifest().index_checksum == index; });
  return store != stores_.end() ? *store : nullptr;
}

BrickFile SharedReads::readKept(const StoreReader& store, const BrickKey& key, bool likely) {
  const auto place = std::find(stores_.begin(), stores_.end(), &store);
  BrickFile out = files_->get(store, {key, static_cast<int>(place - stores_.begin())}, likely);
  if (out.from_disk) countRead(*out.bytes);
  return out;
}

void SharedReads::countRead(const std::vector<std::byte>& file) {
  const Lock lock(mutex_);
  ++counts_.read;
  counts_.read_bytes += file.size();
}

// Requests a file from its home. Returns nothing if the home has no valid file.
std::optional<BrickFile> SharedReads::requestFrom(int home, const StoreReader& store, const BrickKey& key) {
  ProfileScope span(Activity::kRead);
  if (span.traced()) {
    span.note("brick", brickPath(key).native());
    span.note("from rank", static_cast<std::uint64_t>(home));
  }
  Trailer trailer{Kind::kRequest, 0, 0, store.manifest().index_checksum, key};
  {
    const Lock lock(mutex_);
    if (!requesting_) return std::nullopt;
    trailer.number = next_request_++;
    answers_[trailer.number];
  }
  send(home, trailer, nullptr);
  std::optional<BrickFile> out;
  {
    Lock lock(mutex_);
    const auto place = answers_.find(trailer.number);
    changed_.wait(lock, [&] { return place->second.there || abandoned_; });
    out = std::move(place->second.file);
    answers_.erase(place);
  }
  changed_.notify_all();
  if (!out || !store.check(key, *out->bytes)) return std::nullopt;
  const Lock lock(mutex_);
  ++counts_.received;
  counts_.received_bytes += out->bytes->size();
  return out;
}

void SharedReads::send(int to, const Trailer& trailer, const std::vector<std::byte>* file) {
  std::vector<std::byte> message;
  const std::size_t bytes = file != nullptr ? file->size() : 0;
  message.reserve(bytes + sizeof trailer);
  if (file != nullptr) message.assign(file->begin(), file->end());
  message.resize(bytes + sizeof trailer);
  std::memcpy(message.data() + bytes, &trailer, sizeof trailer);
  ranks_.send(to, kReadsTag, std::move(message));
}

bool SharedReads::isBusy() {
  const Lock lock(mutex_);
  return !answers_.empty() || serving_bytes_ > 0;
}

void SharedReads::receive(const std::stop_token& stop) {
  Trace::nameThread("receives");
  try {
    while (!stop.stop_requested()) {
      if (std::optional<RankMessage> message = ranks_.poll(kReadsTag))
        handle(*std::move(message));
      else
        std::this_thread::sleep_for(isBusy() ? kShortPause : kLongPause);
    }
  } catch (...) {
    fail();
  }
}

void SharedReads::handle(RankMessage message) {
  Trailer trailer;
  if (message.bytes.size() < sizeof trailer) return;
  std::memcpy(&trailer, message.bytes.data() + message.bytes.size() - sizeof trailer, sizeof trailer);
  message.bytes.resize(message.bytes.size() - sizeof trailer);
  if (trailer.kind == Kind::kAnswer && !message.bytes.empty())
    send(message.from, {Kind::kTaken, 0, message.bytes.size(), trailer.store, trailer.key}, nullptr);
  {
    const Lock lock(mutex_);
    switch (trailer.kind) {
      case Kind::kRequest:
        requests_.push_back({message.from, trailer.number, trailer.store, trailer.key});
        break;
      case Kind::kAnswer: {
        const auto place = answers_.find(trailer.number);
        if (place == answers_.end()) break;
        place->second.there = true;
        if (message.bytes.empty()) break;
        place->second.file =
            BrickFile{std::make_shared<const std::vector<std::byte>>(std::move(message.bytes)), trailer.from_disk != 0};
        break;
      }
      case Kind::kTaken:
        serving_bytes_ -= trailer.number;
        break;
    }
  }
  changed_.notify_all();
}

void SharedReads::serve(const std::stop_token& stop) {
  Trace::nameThread("serves");
  Lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return !requests_.empty(); })) {
    const Request request = requests_.front();
    requests_.pop_front();
    ++serving_;
    try {
      answer(request, lock);
    } catch (...) {
      if (lock.owns_lock()) lock.unlock();
      fail();
      lock.lock();
    }
    --serving_;
    changed_.notify_all();
  }
}

// A file that fails to read is answered without bytes; the requesting rank then reads the file and reports the error.
void SharedReads::answer(const Request& request, Lock& lock) {
  Trailer trailer{Kind::kAnswer, 0, request.number, request.store, request.key};
  const StoreReader* const store = openedStore(request.store);
  const bool known = store != nullptr && store->index().contains(request.key);
  const std::uint64_t bytes = known ? store->index().at(request.key).file_bytes : 0;
  bool sent = false;
  if (bytes > 0 && bytes <= kLargestSent) {
    changed_.wait(lock, [&] {
      return abandoned_ || serving_bytes_ == 0 || serving_bytes_ + kCopies * bytes <= largest_serving_bytes_;
    });
    serving_bytes_ += kCopies * bytes;
    lock.unlock();
    try {
      const BrickFile file = readKept(*store, request.key);
      trailer.from_disk = file.from_disk ? 1 : 0;
      send(request.from, trailer, file.bytes.get());
      sent = true;
    } catch (...) {
    }
    lock.lock();
    serving_bytes_ -= sent ? (kCopies - 1) * bytes : kCopies * bytes;
  }
  if (sent) {
    ++counts_.sent;
    counts_.sent_bytes += bytes;
    return;
  }
  lock.unlock();
  send(request.from, trailer, nullptr);
  lock.lock();
}

void SharedReads::finish() {
  {
    Lock lock(mutex_);
    requesting_ = false;
    changed_.wait(lock, [&] { return answers_.empty(); });
    if (failure_) std::rethrow_exception(failure_);
  }
  ranks_.barrier();
  // All ranks have their answers; only acknowledgements are on their way.
  Lock lock(mutex_);
  changed_.wait(lock, [&] { return abandoned_ || (requests_.empty() && serving_ == 0 && serving_bytes_ == 0); });
}

void SharedReads::fail() {
  {
    const Lock lock(mutex_);
    if (!failure_) failure_ = std::current_exception();
  }
  abandon();
}

void SharedReads::abandon() {
  {
    const Lock lock(mutex_);
    requesting_ = false;
    abandoned_ = true;
  }
  changed_.notify_all();
}

SharedReadCounts SharedReads::counts() const {
  const Lock lock(mutex_);
  return counts_;
}

}  // namespace kiln
