// All frames of a job, one after the other: unattended, interrupted, and gone on with.
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

/// Told how a sequence goes, by the thread that runs it. `done` counts frames that are drawn, kept or failed. Where the
/// files of a frame are written while the next one is drawn, that one is started before this one is done.
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
  bool resume = false;  // frames whose files are there and whole are kept
  /// A frame is drawn in tiles, which are kept until its files are there; those of an earlier run with `resume`.
  bool checkpoint = false;
  StoreFor store_for;  // if not given, volumes are stores
  /// That share the frames; each calls runSequence with the same job. Null is this process alone.
  Ranks* ranks = nullptr;
  /// Where ranks share bricks: this rank's own part of the store (ranks/split_store.h), in whose name a run of # is
  /// the rank's number, from 1 on; if not given, all read the job's.
  std::filesystem::path store_local;
};

struct SequenceResult {
  RenderStatistics statistics;  // frames that were drawn, kept and failed
  std::string first_failure;    // what the error of the first that failed says; else empty
};

/// Whether one process writes the files of a frame while it draws the next, if memory is left for that: a PNG most of
/// all is made by one thread, whatever others do. Of a time series one store is open at a time.
bool writesBehind(const RenderJob& job);

/// What drawing them so has in memory beside the picture: tiles and a band of rows, or tiles of other ranks.
MemoryBeside besideBytes(const RenderJob& job, const SequenceOptions& options);

/// Draws the job's frames and writes their files and its video. Bricks stay in memory from frame to frame; of a time
/// series, one store is open at a time. A frame that fails costs no other one, but for a job of one frame; no video is
/// made then. throws: Error kUsage where the job as a whole cannot be drawn, kExists where, resuming, a file is of
/// another job; kCancelled saying how to go on; kNotFound, kIo of the video.
/// Of several ranks, the first tells the listener and returns the result; an error of another that is no frame's alone
/// is thrown there.
SequenceResult runSequence(const RenderJob& job, const SequenceOptions& options, Progress& progress,
                           SequenceListener& listener);

}  // namespace kiln
