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

/// Pictures of one list of volumes.
class Drawing {
 public:
  explicit Drawing(std::vector<std::shared_ptr<const BrickedVolume>> volumes) : volumes_(std::move(volumes)) {}
  /// Draws the job's first frame. Bricks stay in memory for later pictures of equal memory. thread: any; waits for its
  /// turn. throws: as ViewPainter.
  std::shared_ptr<Picture> draw(const RenderJob& job, Progress& progress);

 private:
  struct Session;

  const std::vector<std::shared_ptr<const BrickedVolume>> volumes_;
  DrawingTurns turns_;
  std::shared_ptr<Session> session_;
};

class Volume {
 public:
  explicit Volume(std::shared_ptr<const BrickedVolume> volume)
      : volume_(std::move(volume)), drawing_(new Drawing({volume_})) {}

  const std::shared_ptr<const BrickedVolume>& bricks() const { return volume_; }
  Drawing& drawing() const { return *drawing_; }

 private:
  const std::shared_ptr<const BrickedVolume> volume_;
  const std::unique_ptr<Drawing> drawing_;
};

/// Opens a store, or a volume file, whose store is made first if it is missing. `store_directory`: as `--store`.
std::shared_ptr<const BrickedVolume> openFile(const std::filesystem::path& path, const SourceWords& words,
                                              const std::filesystem::path& store_directory, bool labels,
                                              std::uint64_t memory_bytes, Progress& progress);

void bindVolume(py::module_& module);

}  // namespace kiln::python
