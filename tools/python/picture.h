// A drawn frame in memory, for Python.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "job/command/given_flags.h"
#include "python/call.h"
#include "sequence/frame_files.h"
#include "store/bricked_volume.h"

namespace kiln::python {

/// Pixels do not change after construction.
class Picture {
 public:
  /// `job` names the volumes as the headers of files do. `volume` is the job's first.
  Picture(RenderJob job, int frame, DrawnFrame drawn, std::shared_ptr<const BrickedVolume> volume);

  std::size_t views() const { return drawn_.views.size(); }
  int frame() const { return frame_; }
  /// The picture of one eye with its background, as an EXR holds it.
  const Image& light(std::size_t view) const { return light_.empty() ? drawn_.views[view].image : light_[view]; }
  const FrameStatistics& statistics() const { return drawn_.statistics; }
  /// Returns the colours as a PNG shows them. shape: rows of R G B A of 8 bits; straight alpha.
  std::vector<std::uint8_t> srgbBytes(std::size_t view) const;
  /// Returns the bytes of the PNG that `save` writes.
  std::vector<std::byte> png(std::size_t view) const;
  /// Writes a file as `kiln render -o` does: of the right eye for view 1, else of all views. `flags` are options of
  /// files. throws: as writeFrame; Error kUsage for other options or a name without a file.
  void save(std::size_t view, const std::filesystem::path& path, const GivenFlags& flags) const;
  /// Writes the files that the job names. throws: as writeFrame.
  void writeFiles() const;
  /// Returns the job with every choice made.
  std::string jobText() const;

 private:
  /// Return the job of all views, or of the right eye for view 1; the frame of the right eye alone.
  RenderJob jobOf(std::size_t view) const;
  DrawnFrame rightEye() const;
  /// Writes the files of a job of the picture.
  void write(const RenderJob& job, DrawnFrame drawn) const;

  const RenderJob job_;
  const int frame_;
  const DrawnFrame drawn_;    // without a background that files lay
  std::vector<Image> light_;  // by view; empty if equal to the pictures of `drawn_`
  const std::shared_ptr<const BrickedVolume> volume_;
};

void bindPicture(py::module_& module);

}  // namespace kiln::python
