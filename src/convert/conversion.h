// The work of a conversion. Lanes take bricks of level 0 as they become free, encode them, and build the coarser bricks
// that have become possible. Several processes can share the work: each takes bricks of level 0 while there are any,
// and builds its own share of the coarser bricks. The first rank keeps the journal.
#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <optional>
#include <vector>

#include "cluster/ranks.h"
#include "convert/convert.h"
#include "convert/plan.h"
#include "convert/pyramid/brick_shares.h"
#include "convert/pyramid/pyramid_builder.h"
#include "convert/pyramid/rank_exchange.h"
#include "convert/resume/journal.h"
#include "convert/stream/forward_window.h"
#include "convert/stream/value_counter.h"
#include "convert/write_behind.h"

namespace kiln {

class Conversion {
 public:
  /// The inputs of a conversion. requires: all outlive it.
  struct Parts {
    VolumeSource& source;
    StoreWriter& writer;
    const std::filesystem::path& directory;
    const ConversionPlan& plan;
    bool half;
    Ranks& ranks;
    FileSystem& disk;
    Progress& progress;
  };

  /// Collective. With `resumes`, keeps the bricks in the journal of an earlier conversion whose files are whole.
  Conversion(const Parts& parts, const ConversionIdentity& identity, bool resumes);

  /// Collective. Returns on the first rank when all bricks are made and on the disk, or on their way to the disk; the
  /// writer then has an entry for each brick.
  /// throws: the exceptions of source and disk, Error kCancelled. After an exception the other ranks are not waited
  /// for, and shared files stay as they are: the caller must end the other ranks.
  void run();

  /// Totals of all ranks, on the first rank, after `run`.
  const ValueCounter& counter() const { return counters_.front(); }
  double halfError() const { return half_error_; }
  const std::vector<RankConversion>& rankReports() const { return reports_; }
  /// Finished bricks, including bricks of an earlier conversion; on the first rank, of all ranks.
  std::uint64_t finishedBricks() const { return finished_bricks_; }

 private:
  void adoptFinished(const FinishedBrick& brick);
  void openJournal(const ConversionIdentity& identity);
  std::vector<std::int64_t> bricksToMake(bool in_order) const;
  void resumePyramid();
  void work(std::size_t lane, WriteBehind& disk);
  void makeBrick(std::int64_t i, std::size_t lane, WriteBehind& disk);
  std::vector<BrickKey> brick(const BrickKey& key, std::size_t lane, WriteBehind& disk);
  void build(const BrickKey& key, WriteBehind& disk);
  void buildReady(WriteBehind& disk);
  void buildRest(WriteBehind& disk);
  std::optional<BrickKey> takeReady();
  void addReady(const std::vector<BrickKey>& ready);
  void write(const UnwrittenBrick& unwritten);
  void noteFinished(const FinishedBrick& brick);
  void onRemoteBrick(const FinishedBrick& brick);
  void startExchange();
  void collectResults();
  void throwIfStopped();
  bool isFinished(const BrickKey& key) const;
  std::size_t placeOf(const BrickKey& key) const;

  const Parts parts_;
  StoreWriter& writer_;
  Ranks& ranks_;
  Progress& progress_;
  PyramidBuilder pyramid_;
  std::vector<std::vector<std::byte>> boxes_;      // by lane: buffer for the voxels of a brick of level 0
  std::vector<ValueCounter> counters_, of_brick_;  // by lane: totals, and values of the current brick
  std::vector<std::vector<char>> finished_;        // by level and brick: finished by an earlier conversion
  std::vector<std::vector<char>> known_;           // by level and brick: the writer has an entry
  std::optional<Journal> journal_;                 // on the first rank
  std::optional<BrickShares> shares_;
  std::optional<ForwardWindow> window_;
  std::mutex mutex_;  // guards the members below
  std::condition_variable changed_;
  std::vector<BrickKey> ready_;  // to be built
  std::uint64_t left_to_build_ = 0;
  bool failed_ = false;
  std::uint64_t done_ = 0, finished_bricks_ = 0;
  RankConversion report_;
  double waited_s_ = 0;  // summed over all lanes
  std::chrono::steady_clock::time_point began_;
  std::vector<RankConversion> reports_;
  double half_error_ = 0;
  std::optional<RankExchange> exchange_;  // with several ranks only; constructed last and destroyed first
};

}  // namespace kiln
