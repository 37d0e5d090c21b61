// Ranks that draw the same volumes read each brick file once among them. Every file has a home, the rank that all know
// to be the one that reads it: it keeps the bytes as they are on the disk, and sends them to whoever asks. Who gets
// none, because its home cannot read the file, or has another volume open, reads it itself; so every error is the one
// that reading it here gives, and nothing depends on what another rank can do.
//
// Nobody waits in a ring: bytes for others are read by threads that ask nobody, and a thread of its own reads the mail,
// so that a rank answers while it draws, while it waits for a file of another's, and when it has nothing left to draw.
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

/// The rank that reads a brick of the first volume for all.
struct BrickHome {
  BrickKey key;
  std::int32_t rank = 0;
  std::int32_t others = 0;  // ranks that are likely to need it, too; of none it is the first to make room
};

class SharedReads : public BrickFiles {
 public:
  /// Collective in effect: each rank has one, and calls `finish`. requires: `ranks` outlives this.
  explicit SharedReads(Ranks& ranks);
  ~SharedReads() override;
  SharedReads(const SharedReads&) = delete;
  SharedReads& operator=(const SharedReads&) = delete;

  /// The largest file of all the stores. unit: bytes.
  static std::uint64_t largestFileOf(const std::vector<const StoreReader*>& stores);
  /// What of `left_bytes` this rank takes for files: 0 where it is too little for files of `largest_bytes`.
  static std::uint64_t shareOf(std::uint64_t budget_bytes, std::uint64_t left_bytes, std::uint64_t largest_bytes);

  /// Bricks that a rank of their own is likely to need; others' homes are scattered. requires: the same on all ranks,
  /// before anything is fetched.
  void settle(const std::vector<BrickHome>& homes);

  /// From now on files of these stores are fetched and sent, with so much memory. requires: nothing is open; more than
  /// 0 bytes, as `shareOf` has it; they stay until `close`.
  void open(const std::vector<const StoreReader*>& stores, std::uint64_t bytes);
  /// Others who ask get none from now on. requires: nobody fetches.
  void close();

  BrickFile fetch(const StoreReader& store, const BrickKey& key) override;

  /// Collective. What is fetched from now on each rank reads itself; returns when nobody asks any more. throws: why
  /// mail could not be read.
  void finish();
  /// This rank has failed, and will end all: what waits for others waits no longer.
  void abandon();

  SharedReadCounts counts() const;

 private:
  enum class Kind : std::int32_t { kAsk, kAnswer, kTaken };
  struct Letter;
  struct Question;
  struct Answer {
    bool there = false;
    std::optional<BrickFile> file;
  };
  using Lock = std::unique_lock<std::mutex>;

  BrickHome homeOf(const StoreReader& store, const BrickKey& key) const;
  std::optional<BrickFile> ask(int home, const StoreReader& store, const BrickKey& key);
  BrickFile readHere(const StoreReader& store, const BrickKey& key);
  const StoreReader* openedStore(const Hash128& index) const;
  BrickFile readKept(const StoreReader& store, const BrickKey& key, bool likely = true);
  void countRead(const std::vector<std::byte>& file);
  void send(int to, const Letter& letter, const std::vector<std::byte>* file);
  bool inARush();
  void readMail(const std::stop_token& stop);
  void handle(RankMessage message);
  void serve(const std::stop_token& stop);
  void answer(const Question& question, Lock& lock);

  Ranks& ranks_;
  std::map<BrickKey, BrickHome> homes_;
  mutable std::mutex mutex_;  // guards what follows
  std::condition_variable_any changed_;
  bool asking_ = true;      // else each reads by itself
  bool abandoned_ = false;  // nothing will be answered
  std::exception_ptr failure_;
  std::vector<const StoreReader*> stores_;
  std::unique_ptr<EncodedBricks> files_;
  std::uint64_t largest_serving_bytes_ = 0, serving_bytes_ = 0;  // for others: being read, and on their way
  int serving_ = 0;                                              // threads that are answering
  std::uint64_t asked_ = 0;                                      // numbers questions
  std::map<std::uint64_t, Answer> answers_;                      // to those that are asked
  std::deque<Question> questions_;                               // of others
  SharedReadCounts counts_;
  std::vector<std::jthread> threads_;
};

/// Opens stores for as long as it lives, where there are other ranks and memory for it.
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
  /// Where bricks are to be fetched; null for the stores' own disk.
  BrickFiles* files() const { return shared_; }

 private:
  SharedReads* const shared_;
};

}  // namespace kiln
