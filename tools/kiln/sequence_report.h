// Reports the frames of a job: a line with the remaining time for people, or an event for programs.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "commands.h"
#include "sequence/sequence.h"

namespace kiln::tool {

/// Amount of text on standard output.
/// - kQuiet: nothing.
/// - kBrief: a short line for each frame: time, bytes read, peak memory.
/// - kVerbose: also counts of bricks and voxels, and the peak of the cache.
/// - kEvents: JSON objects, one per line, each with "event" and "time" (ISO 8601, UTC). Events: started, frame_started,
///   frame_progress (a few a second), frame_done, frame_kept, frame_failed, warning; at the end finished, failed or
///   interrupted.
enum class ReportKind { kQuiet, kBrief, kVerbose, kEvents };

class SequenceReport : public SequenceListener {
 public:
  SequenceReport(TerminalProgress& progress, ReportKind kind);
  ~SequenceReport() override;
  SequenceReport(const SequenceReport&) = delete;
  SequenceReport& operator=(const SequenceReport&) = delete;

  void started(const RenderJob& job, const std::vector<int>& frames) override;
  void frameStarted(int frame) override;
  void frameDone(const RenderJob& job, const FrameStatistics& frame, std::size_t done) override;
  void frameKept(const RenderJob& job, int frame, std::size_t done) override;
  void frameFailed(int frame, const Error& error, std::size_t done) override;

  void finished(const RenderJob& job, const SequenceResult& result);
  /// Reports the error that ended the sequence.
  void ended(const Error& error);

 private:
  using Clock = std::chrono::steady_clock;
  double seconds() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }
  /// Estimates the time for the remaining frames from the frames drawn so far; 0 before the first. unit: seconds.
  double secondsLeft(std::size_t done) const;
  void showOverall(std::size_t done);
  void drawingGoesOn(const TerminalProgress::Numbers& numbers) const;
  void frameEnded(int frame);

  std::string frameLine(const RenderJob& job, const FrameStatistics& frame) const;
  bool emitsEvents() const { return kind_ == ReportKind::kEvents; }
  // Prints unless the report is quiet.
  void print(const std::string& line) const;

  TerminalProgress& progress_;
  const ReportKind kind_;
  Clock::time_point begin_ = Clock::now();
  std::size_t frames_ = 0, drawn_ = 0, kept_ = 0;
  std::optional<int> drawing_;
  std::string only_line_;
};

}  // namespace kiln::tool
