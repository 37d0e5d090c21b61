// What is the same for a job's frames however ranks share them: the stores, the frames that are there already, which
// the ranks look for together, what the first rank hears of each frame, and each rank's statistics.
#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "cluster/ranks.h"
#include "ranks/rank_messages.h"
#include "ranks/shared_reads.h"
#include "sequence/sequence.h"

namespace kiln {

class RankedSequence {
 public:
  RankedSequence(const RenderJob& job, const SequenceOptions& options, StoreFor stores, Progress& progress,
                 SequenceListener& listener, std::optional<VoxelBox> part = std::nullopt, bool share_reads = false);
  virtual ~RankedSequence() = default;
  RankedSequence(const RankedSequence&) = delete;
  RankedSequence& operator=(const RankedSequence&) = delete;

  SequenceResult run();

 protected:
  /// Draws `toDraw()`; the first rank returns when it has heard of all of them.
  virtual void share() = 0;
  /// Of `share`, as the statistics name it.
  virtual const char* sharedBy() const = 0;

  /// Frames that are not kept; messages name them by their place here.
  const std::vector<int>& toDraw() const { return to_draw_; }
  bool single() const { return frames_.numbers().size() == 1; }
  /// Runs `body`. An error in it is that frame's alone, unless the job has no other, or has been told to stop.
  void attempt(FrameReport& report, const std::function<void()>& body);
  void write(OpenedJob& opened, std::uint32_t frame, DrawnFrame& drawn);
  /// On the first rank: a frame is begun, and what became of it.
  void started(std::uint32_t frame);
  void hear(const FrameReport& report);

  const RenderJob& job_;
  Ranks& ranks_;
  Progress& progress_;
  const std::unique_ptr<SharedReads> shared_reads_;  // null where each rank reads for itself
  SequenceFrames frames_;
  RankStatistics own_;
  std::size_t heard_ = 0;

 private:
  void findKept();
  void shareAndRead();
  void finish();

  const bool resume_;
  SequenceListener& listener_;
  std::vector<int> to_draw_;
  std::size_t done_ = 0;
  SequenceResult result_;
};

/// Collective. The store of each volume of the job; the first rank makes those that are foreign files.
StoreFor sharedStores(const RenderJob& job, const SequenceOptions& options);

}  // namespace kiln
