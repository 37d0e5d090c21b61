// A window of whole slices over a source that can only be read forwards, so that bricks with their aprons can be cut
// from a compressed stream in one pass. Layers of bricks overlap by twice the apron: those slices are kept, not
// re-read.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ingest/volume_source.h"

namespace kiln {

class SlabWindow {
 public:
  /// The memory a window of `slices` slices takes. unit: bytes.
  static std::uint64_t bytesFor(const SourceInfo& info, std::int64_t slices);

  explicit SlabWindow(VolumeSource& source) : source_(source) {}

  /// Makes slices [lo, hi) available; lo and hi never go back. thread: one at a time, no `copy` meanwhile.
  void advance(std::int64_t lo, std::int64_t hi);
  /// Copies a box of the available slices. shape: as VolumeSource::read. thread: safe.
  void copy(const VoxelBox& box, std::span<std::byte> out) const;

 private:
  VolumeSource& source_;
  std::int64_t lo_ = 0, hi_ = 0;
  std::vector<std::byte> slices_;
};

}  // namespace kiln
