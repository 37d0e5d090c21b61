// A time series has a volume for each frame. A joined volume stands for all frames when a camera is framed and a
// transfer function is chosen: both depend neither on the frame nor on the frames that a process draws.
#pragma once

#include <string>
#include <vector>

#include "store/manifest/manifest.h"

namespace kiln {

struct SeriesLook {
  /// A joined volume for each volume of the job, all placed in a shared world (Manifest::placeIn).
  std::vector<Manifest> volumes;
  std::string frames;  // the joined frames, as a text for parseFrames; empty if all frames have the same volumes
  /// A sentence on the joined frames, for users.
  std::string choice;
};

/// Joins `frames` into a volume: the box around all boxes, in the axes of the first frame; the range of all values; the
/// sum of the histograms. All else is the first frame's. requires: a frame or more.
Manifest unionOf(const std::vector<Manifest>& frames);

}  // namespace kiln
