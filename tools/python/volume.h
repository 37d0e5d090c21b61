// An open volume, for Python: facts, voxels, and pictures from one cache.
//
// Threads. Threads of Python may draw at once: they draw in turn (view/drawing_turns.h), so that the cache has one
// caller, each on all cores. Voxels are read beside, without the cache.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "python/arrays.h"
#include "python/job_words.h"
#include "python/picture.h"
#include "view/drawing_turns.h"
#include "view/view_painter.h"

namespace kiln::python {

/// Passes reports on to the call that draws. thread: as Progress, but for Scope.
class Relay final : public Progress {
 public:
  void advance(const char* step, const char* unit, std::uint64_t done, std::uint64_t total) override {
    if (call_ != nullptr) call_->advance(step, unit, done, total);
  }
  void note(const std::string& sentence) override {
    if (call_ != nullptr) call_->note(sentence);
  }
  void warn(const std::string& sentence) override {
    if (call_ != nullptr) call_->warn(sentence);
  }
  bool cancelled() const override { return call_ != nullptr && call_->cancelled(); }

  /// Sets the call until destruction. thread: while nobody reports.
  class Scope {
   public:
    Scope(Relay& relay, Progress& call) : relay_(relay) { relay_.call_ = &call; }
    ~Scope() { relay_.call_ = nullptr; }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    Relay& relay_;
  };

 private:
  Progress* call_ = nullptr;
};

std::vector<const BrickedVolume*> pointersTo(const std::vector<std::shared_ptr<const BrickedVolume>>& volumes);

/// Pictures of volumes. Bricks stay in memory for later pictures of the same volumes and of equal memory.
class Drawing {
 public:
  using Volumes = std::vector<std::shared_ptr<const BrickedVolume>>;
  /// Draws the job's first frame. thread: any; waits for its turn. throws: as ViewPainter.
  std::shared_ptr<Picture> draw(const RenderJob& job, const Volumes& volumes, Progress& progress);

 private:
  struct Session;

  DrawingTurns turns_;
  std::shared_ptr<Session> session_;
};

class Volume {
 public:
  explicit Volume(std::shared_ptr<const BrickedVolume> volume) : volume_(std::move(volume)), drawing_(new Drawing()) {}

  const std::shared_ptr<const BrickedVolume>& bricks() const { return volume_; }
  /// Pictures with this volume as the first.
  Drawing& drawing() const { return *drawing_; }

 private:
  const std::shared_ptr<const BrickedVolume> volume_;
  const std::unique_ptr<Drawing> drawing_;
};

/// Open volumes beside the first; Python makes the object.
struct MoreVolumes {
  Drawing::Volumes added, labels;
  std::vector<std::string> functions;  // texts of --tf, or JSON

  /// throws: Error kUsage for a text that is no transfer function.
  AddedVolumes names() const;
  /// Returns all volumes of a picture, in the order of its job.
  Drawing::Volumes behind(const Volume& first) const;
};

/// Returns a store, or the store of a volume file, which is made first if it is missing. `store_directory`: as
/// `--store`. throws: as storeFor.
std::filesystem::path storeForCall(const std::filesystem::path& path, const SourceWords& words,
                                   const std::filesystem::path& store_directory, bool labels,
                                   std::uint64_t memory_bytes, Progress& progress);

void bindVolume(py::module_& module);

}  // namespace kiln::python
