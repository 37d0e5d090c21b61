// The progress of a frame as one count from 0 to its total. Parts drawn in turn (bands of sub-pixels, faces of a
// panorama, eyes) each count their bricks in view, hidden bricks included. With several volumes, a brick counts once
// per tile.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>

#include "base/progress.h"

namespace kiln {

/// The progress of one part. Reports 0 and the total once each; an empty part reports nothing.
class PartProgress {
 public:
  /// requires: `progress` and `unit` outlive this.
  PartProgress(Progress& progress, const char* unit, std::uint64_t total);

  /// Sets the count since the beginning. thread: the part's own.
  void reached(std::uint64_t done);
  /// Reports that `drawn` of `of` equal parts of the next `count` bricks are done. thread: any; one thread reports.
  void within(std::uint64_t count, std::uint64_t drawn, std::uint64_t of);
  void finish();

 private:
  void tell(std::uint64_t done);

  Progress& progress_;
  const char* const unit_;
  const std::uint64_t total_;
  std::uint64_t reached_ = 0, told_ = 0;
  std::mutex telling_;
};

/// The progress of views that are drawn before a frame, as a step of its own. Counts their rows of pixels.
class ViewsProgress : public Progress {
 public:
  /// `rows`: of all views. requires: `step` and `progress` outlive the object.
  ViewsProgress(const char* step, std::uint64_t rows, Progress& progress);

  /// Begins a part of so many rows.
  void begin(int rows) { of_part_ = static_cast<std::uint64_t>(rows); }
  void advance(const char* step, const char* unit, std::uint64_t done, std::uint64_t total) override;
  bool cancelled() const override { return progress_.cancelled(); }
  /// Counts the part as drawn. A part without bricks reports nothing by itself.
  void end();

 private:
  const char* const step_;
  const std::uint64_t rows_;
  std::uint64_t before_ = 0, of_part_ = 0;
  Progress& progress_;
};

/// Adds the progress of the parts to the frame's. Steps before the frame are passed on.
class FrameProgress : public Progress {
 public:
  /// `total`: the sum over all parts; 0 for a single part with its own total. requires: `progress` outlives the object.
  FrameProgress(int frame, std::uint64_t total, Progress& progress);
  void advance(const char* step, const char* unit, std::uint64_t done, std::uint64_t total) override;
  void note(const std::string& sentence) override { progress_.note(sentence); }
  void warn(const std::string& sentence) override { progress_.warn(sentence); }
  bool cancelled() const override { return progress_.cancelled(); }

 private:
  const std::string step_;
  const std::uint64_t total_;
  std::uint64_t before_ = 0;  // count of the finished parts
  Progress& progress_;
};

/// Passes on messages but no counts, for work whose caller counts.
class UncountedProgress : public Progress {
 public:
  /// requires: `progress` outlives the object.
  explicit UncountedProgress(Progress& progress) : progress_(progress) {}
  void note(const std::string& sentence) override { progress_.note(sentence); }
  void warn(const std::string& sentence) override { progress_.warn(sentence); }
  bool cancelled() const override { return progress_.cancelled(); }

 private:
  Progress& progress_;
};

/// Passes on the request to stop alone, for work without reports.
class SilentProgress : public Progress {
 public:
  /// requires: `progress` outlives the object.
  explicit SilentProgress(const Progress& progress) : progress_(progress) {}
  bool cancelled() const override { return progress_.cancelled(); }

 private:
  const Progress& progress_;
};

/// The name of a frame's step of progress.
std::string stepOfFrame(int frame);

}  // namespace kiln
