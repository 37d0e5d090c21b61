// Problem: ranks that draw the same volumes read each brick file once among all ranks.
// Method: every file has a home rank, known to all ranks. The home keeps the file's bytes and sends them on request. A
// rank reads a file itself if the home cannot read the file or has another volume open.
// Invariant: errors are the errors of local reads. No cycle of waiting ranks exists: server threads never request
// files, and a separate thread receives messages while the rank draws, waits or has finished.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "base/hash.h"
#include "cache/encoded_bricks.h"
#include "cluster/ranks.h"
#include "frame/statistics.h"

namespace kiln {

/// The home rank of a brick of the first volume.
struct BrickHome {
  BrickKey key;
  std::int32_t rank = 0;
  std::int32_t others = 0;  // other ranks likely to need the brick; a brick with 0 is evicted first
};

class SharedReads : public BrickSupplier {
 public:
  /// Every rank has one instance and calls `finish`. requires: `ranks` outlives the object.
  explicit SharedReads(Ranks& ranks);
  ~SharedReads() override;
  SharedReads(const SharedReads&) = delete;
  SharedReads& operator=(const SharedReads&) = delete;

  /// Returns the size of the stores' largest brick file. unit: bytes.
  static std::uint64_t largestFileOf(const std::vector<const StoreReader*>& stores);
  /// Returns the part of `left_bytes` for shared files; 0 if files of `largest_bytes` do not fit.
  static std::uint64_t shareOf(std::uint64_t budget_bytes, std::uint64_t left_bytes, std::uint64_t largest_bytes);

  /// Sets the homes of the bricks of a frame; other bricks get a home by hash. requires: equal arguments on all ranks,
  /// before the first fetch.
  void settle(const std::vector<BrickHome>& homes);

  /// Starts to fetch and send files of these stores, within `bytes` of memory. requires: no stores are open; `bytes` is
  /// a result of `shareOf` above 0; the stores outlive `close`.
  void open(const std::vector<const StoreReader*>& stores, std::uint64_t bytes);
  /// Stops sending files of the open stores. requires: no fetch is under way.
  void close();

  /// Returns the bytes of a brick's file, with a valid checksum. May wait. requires: the brick is not constant. thread:
  /// safe. throws: as StoreReader::readFile.
  BrickFile fetch(const StoreReader& store, const BrickKey& key);
  /// Fetches and decodes a brick. requires: the cache has the open stores, in their order.
  SuppliedBrick supply(const StoredBrick& brick) override;

  /// Collective. Each rank reads later fetches itself. Returns once no rank has an open request. throws: the error that
  /// stopped the receiving thread.
  void finish();
  /// Wakes all waiting threads without an answer after this rank has failed.
  void abandon();

  SharedReadCounts counts() const;

 private:
  enum class Kind : std::int32_t { kRequest, kAnswer, kTaken };
  struct Trailer;
  struct Request;
  struct Answer {
    bool there = false;
    std::optional<BrickFile> file;
  };
  using Lock = std::unique_lock<std::mutex>;

  BrickHome homeOf(const StoreReader& store, const BrickKey& key) const;
  std::optional<BrickFile> requestFrom(int home, const StoreReader& store, const BrickKey& key);
  BrickFile readHere(const StoreReader& store, const BrickKey& key);
  const StoreReader* openedStore(const Hash128& index) const;
  BrickFile readKept(const StoreReader& store, const BrickKey& key, bool likely = true);
  void countRead(const std::vector<std::byte>& file);
  void send(int to, const Trailer& trailer, const std::vector<std::byte>* file);
  bool isBusy();
  void receive(const std::stop_token& stop);
  void handle(RankMessage message);
  void serve(const std::stop_token& stop);
  void answer(const Request& request, Lock& lock);
  /// Keeps the exception that is handled, the first only, and abandons all requests.
  void fail();

  Ranks& ranks_;
  std::map<BrickKey, BrickHome> homes_;
  mutable std::mutex mutex_;  // guards the members below; `stores_` and `files_` stay while a thread answers
  std::condition_variable_any changed_;
  bool requesting_ = true;  // false: each rank reads for itself
  bool abandoned_ = false;  // no request will be answered
  bool closing_ = false;    // new requests find no store
  std::exception_ptr failure_;
  std::vector<const StoreReader*> stores_;
  std::unique_ptr<EncodedBricks> files_;
  std::uint64_t largest_serving_bytes_ = 0, serving_bytes_ = 0;  // files read or sent for other ranks: limit, now
  int serving_ = 0;                                              // threads that are answering
  std::uint64_t next_request_ = 0;                               // number of the next request
  std::map<std::uint64_t, Answer> answers_;                      // by number of the request
  std::deque<Request> requests_;                                 // requests of other ranks
  SharedReadCounts counts_;
  std::vector<std::jthread> threads_;
};

/// Keeps stores open for other ranks during its lifetime, if there are other ranks and memory.
class OpenedForRanks {
 public:
  OpenedForRanks(SharedReads* shared, const std::vector<const StoreReader*>& stores, std::uint64_t bytes)
      : shared_(bytes > 0 ? shared : nullptr) {
    if (shared_ != nullptr) shared_->open(stores, bytes);
  }
  ~OpenedForRanks() {
    if (shared_ != nullptr) shared_->close();
  }
  OpenedForRanks(const OpenedForRanks&) = delete;
  OpenedForRanks& operator=(const OpenedForRanks&) = delete;
  /// Returns the supplier of bricks; null: each store itself.
  BrickSupplier* supplier() const { return shared_; }

 private:
  SharedReads* const shared_;
};

}  // namespace kiln
