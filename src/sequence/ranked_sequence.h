// The parts of a sequence that are common to all ways of sharing frames: stores, the search for finished frames,
// reports to rank 0, statistics of the ranks.
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
  /// Draws `toDraw()`; rank 0 returns once it has a report of each frame.
  virtual void share() = 0;
  /// The name of the way of sharing in the statistics.
  virtual const char* sharedBy() const = 0;

  /// The frames to draw. Messages name a frame by its index here.
  const std::vector<int>& toDraw() const { return to_draw_; }
  bool single() const { return frames_.numbers().size() == 1; }
  /// Runs `body`. An error fails only this frame, except in a job of one frame or after a cancellation.
  void attempt(FrameReport& report, const std::function<void()>& body);
  void write(OpenedJob& opened, std::uint32_t frame, DrawnFrame& drawn);
  /// Handle, on rank 0, the start and the report of a frame.
  void started(std::uint32_t frame);
  void record(const FrameReport& report);

  const RenderJob& job_;
  Ranks& ranks_;
  Progress& progress_;
  const std::unique_ptr<SharedReads> shared_reads_;  // null: each rank reads for itself
  SequenceFrames frames_;
  RankStatistics own_;
  std::size_t recorded_ = 0;

 private:
  bool isKept(int frame);
  void findKept();
  void shareAndRead();
  void finish();

  const bool resume_;
  SequenceListener& listener_;
  std::vector<int> to_draw_;
  std::size_t done_ = 0;
  SequenceResult result_;
};

/// Collective. Returns the store of each volume; rank 0 converts foreign files. The store of a file that cannot be
/// converted is an error of its frames in a time series; else rank 0 throws here.
StoreFor sharedStores(const RenderJob& job, const SequenceOptions& options);

}  // namespace kiln
