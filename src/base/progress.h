// How long work tells its caller how far it is, and learns that the user wants it to stop.
#pragma once

#include <cstdint>

#include "base/error.h"

namespace kiln {

/// Told by long work; the default tells nobody. thread: `advance` is called from any thread, one call at a time;
/// `cancelled` from several.
class Progress {
 public:
  virtual ~Progress() = default;
  /// `done` of `total` units ("voxels", "bricks", "frames") of the step called `step` are finished.
  virtual void advance(const char* /*step*/, const char* /*unit*/, std::uint64_t /*done*/, std::uint64_t /*total*/) {}
  /// A sentence the user should see (a choice made for them, a value out of the ordinary).
  virtual void note(const std::string& /*sentence*/) {}
  /// A sentence on why the result is not what was asked for. The default notes the sentence after "warning: ".
  virtual void warn(const std::string& sentence) { note("warning: " + sentence); }
  /// True once the user has asked to stop.
  virtual bool cancelled() const { return false; }

  void throwIfCancelled(const char* doing) const {
    if (cancelled()) throw Error(ErrorCode::kCancelled, std::string("interrupted while ") + doing);
  }
};

}  // namespace kiln
