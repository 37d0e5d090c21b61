// How far a frame is, as one count that grows from nothing to its total. The parts that it is drawn in one after the
// other (bands of sub-pixels, faces of a panorama, eyes) each count what they draw: bricks in view, one that turns out
// to be hidden as much as one that is drawn; of several volumes, which are swept at once, the tiles that each of their
// bricks is drawn into.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>

#include "base/progress.h"

namespace kiln {

/// What one part tells: first that nothing is done of it, last and once that all is. A part of nothing tells nothing.
class PartProgress {
 public:
  /// requires: `progress` and `unit` outlive this.
  PartProgress(Progress& progress, const char* unit, std::uint64_t total);

  /// So much is done from the beginning. thread: the part's own.
  void reached(std::uint64_t done);
  /// Of the next `count`, which are drawn together, `drawn` of `of` tiles are. thread: any, one of which tells.
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

/// Tells the frame's progress what its parts tell theirs.
class FrameProgress : public Progress {
 public:
  /// `total` is of all parts; 0 where there is one, which knows its own. requires: `progress` outlives this.
  FrameProgress(int frame, std::uint64_t total, Progress& progress);
  void advance(const char* step, const char* unit, std::uint64_t done, std::uint64_t total) override;
  void note(const std::string& sentence) override { progress_.note(sentence); }
  void warn(const std::string& sentence) override { progress_.warn(sentence); }
  bool cancelled() const override { return progress_.cancelled(); }

 private:
  const std::string step_;
  const std::uint64_t total_;
  std::uint64_t before_ = 0;  // of the parts that are finished
  Progress& progress_;
};

/// Of work whose caller counts it in its own way: says what there is to say, but not how far it is.
class UncountedProgress : public Progress {
 public:
  /// requires: `progress` outlives this.
  explicit UncountedProgress(Progress& progress) : progress_(progress) {}
  void note(const std::string& sentence) override { progress_.note(sentence); }
  void warn(const std::string& sentence) override { progress_.warn(sentence); }
  bool cancelled() const override { return progress_.cancelled(); }

 private:
  Progress& progress_;
};

/// The step that a frame's progress has.
std::string stepOfFrame(int frame);

}  // namespace kiln
