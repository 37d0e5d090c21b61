// Draws all frames of a job: unattended, interruptible, resumable.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/progress.h"
#include "cluster/ranks.h"
#include "frame/statistics.h"
#include "job/render_job.h"
#include "sequence/sequence_frames.h"

namespace kiln {

/// Receives the progress of a sequence on the calling thread. `done` counts drawn, kept and failed frames. A frame may
/// start before the previous frame is done, because files are written behind.
class SequenceListener {
 public:
  virtual ~SequenceListener() = default;
  virtual void started(const RenderJob& /*job*/, const std::vector<int>& /*frames*/) {}
  virtual void frameStarted(int /*frame*/) {}
  virtual void frameDone(const RenderJob& /*job*/, const FrameStatistics& /*frame*/, std::size_t /*done*/) {}
  virtual void frameKept(const RenderJob& /*job*/, int /*frame*/, std::size_t /*done*/) {}
  virtual void frameFailed(int /*frame*/, const Error& /*error*/, std::size_t /*done*/) {}
};

struct SequenceOptions {
  bool resume = false;  // keep frames whose files exist and are whole
  /// Draw a frame in tiles and keep the tiles until its files are written; with `resume`, reuse an earlier run's tiles.
  bool checkpoint = false;
  StoreFor store_for;  // if empty, all volumes are stores
  /// The ranks that share the frames, each in runSequence with the same job. Null: a single process.
  Ranks* ranks = nullptr;
  /// With `--distribute bricks`: this rank's part of the store (ranks/split_store.h); # in the name stands for the
  /// rank's number, from 1 on. If empty, all ranks read the job's store.
  std::filesystem::path store_local;
};

struct SequenceResult {
  RenderStatistics statistics;  // covers frames that were drawn, kept and failed
  std::string first_failure;    // the first error of a frame; else empty
};

/// Returns true if one process writes the files of a frame while it draws the next frame, given memory. Deflating a PNG
/// takes one thread. In a time series one store is open at a time.
bool writesBehind(const RenderJob& job);

/// Returns the memory beside the picture: tiles and a band of rows, or tiles of other ranks.
MemoryBeside besideBytes(const RenderJob& job, const SequenceOptions& options);

/// Draws the job's frames and writes their files and the video. Bricks stay in memory from frame to frame; in a time
/// series one store is open at a time. A failing frame does not stop later frames, but prevents the video; with a
/// single frame its error is thrown. With several ranks, rank 0 calls the listener, returns the result, and throws
/// errors of other ranks that concern several frames.
/// throws: Error kUsage for a job that cannot be drawn; kExists if resuming meets a file of another job; kCancelled,
/// with the way to resume; kNotFound, kIo of the video.
SequenceResult runSequence(const RenderJob& job, const SequenceOptions& options, Progress& progress,
                           SequenceListener& listener);

}  // namespace kiln
