// A dense volume that can only be read forwards, and checks its reader against the contract of ReadOrder::kForward.
#pragma once

#include <algorithm>
#include <atomic>
#include <stdexcept>

#include "base/error.h"
#include "support/volumes/procedural.h"

namespace kiln::test {

/// requires: the volume outlives the source. A read out of order or beside another is a failure, not bad luck.
class ForwardSource : public VolumeSource {
 public:
  /// After `reads` reads the file ends: Error kFormat.
  explicit ForwardSource(const DenseVolume& volume, int reads = -1) : dense_(volume), reads_left_(reads) {}

  const SourceInfo& info() const override { return dense_.info(); }
  ReadOrder order() const override { return ReadOrder::kForward; }
  void read(const VoxelBox& box, std::span<std::byte> out) override {
    if (reading_.exchange(true)) throw std::logic_error("two reads at once");
    const Extent3 dims = info().geometry.dims, n = box.extent();
    const bool run = n.x == dims.x && (n.y == dims.y || n.z == 1);
    if (!run || (box.lo.z * dims.y + box.lo.y) * dims.x != next_voxel_) throw std::logic_error("read out of order");
    if (reads_left_ == 0) throw Error(ErrorCode::kFormat, "scan.raw.gz", "byte 4711", "the file ends here");
    --reads_left_;
    dense_.read(box, out);
    largest_read_bytes_ = std::max(largest_read_bytes_, out.size());
    next_voxel_ += box.count();
    reading_ = false;
  }

  /// Number of slices read so far. unit: slices. thread: any.
  std::int64_t slicesRead() const { return next_voxel_ / (info().geometry.dims.x * info().geometry.dims.y); }
  std::size_t largestReadBytes() const { return largest_read_bytes_; }

 private:
  DenseSource dense_;
  int reads_left_;
  std::atomic<bool> reading_ = false;
  std::atomic<std::int64_t> next_voxel_ = 0;
  std::size_t largest_read_bytes_ = 0;
};

}  // namespace kiln::test
