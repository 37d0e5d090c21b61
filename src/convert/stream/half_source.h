// Wraps a source and rounds its values to 16-bit floats: smaller bricks, at a known error.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "ingest/source/wrapped_source.h"

namespace kiln {

/// The effect of rounding on finite values. unit: the volume's values.
struct HalfLoss {
  double largest_error = 0;
  double largest_exact = 0;    // magnitude before rounding
  double largest_rounded = 0;  // magnitude after rounding

  void include(const HalfLoss& other);
  /// A sentence if values were cut at the largest half, or if all values but 0 became 0; else empty.
  std::string warning() const;
};

/// Rounds voxels of `type` to the nearest half floats. Values beyond the range of half become its largest value;
/// infinities and NaN stay.
HalfLoss roundToHalf(VoxelType type, std::span<std::byte> voxels);

class HalfSource : public WrappedSource {
 public:
  /// throws: Error kUsage if the source has 32-bit integers or doubles.
  explicit HalfSource(std::unique_ptr<VolumeSource> exact);

  /// Values beyond the range of half become its largest value; infinities and NaN stay.
  void read(const VoxelBox& box, std::span<std::byte> out) override;

  /// The loss so far. thread: safe.
  HalfLoss loss() const;

 private:
  mutable std::mutex mutex_;
  HalfLoss loss_;
};

}  // namespace kiln
