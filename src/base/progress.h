// Progress reports of long work, and the request to stop.
#pragma once

#include <cstdint>

#include "base/error.h"

namespace kiln {

/// Receives the progress of long work; the default ignores all reports. thread: `advance` is called from any thread,
/// one call at a time; `cancelled` from several threads at once.
class Progress {
 public:
  virtual ~Progress() = default;
  /// `done` of `total` units ("voxels", "bricks", "frames") of the step called `step` are finished.
  virtual void advance(const char* /*step*/, const char* /*unit*/, std::uint64_t /*done*/, std::uint64_t /*total*/) {}
  /// A sentence for the user (an automatic choice, an unusual value).
  virtual void note(const std::string& /*sentence*/) {}
  /// A sentence on a result that differs from the request. The default notes the sentence after "warning: ".
  virtual void warn(const std::string& sentence) { note("warning: " + sentence); }
  /// True after the user requested a stop.
  virtual bool cancelled() const { return false; }

  void throwIfCancelled(const char* doing) const {
    if (cancelled()) throw Error(ErrorCode::kCancelled, std::string("interrupted while ") + doing);
  }
};

}  // namespace kiln
