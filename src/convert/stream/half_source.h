// Wraps a source and rounds its values to 16-bit floats: smaller bricks, at a known error.
#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "ingest/source/volume_source.h"

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

class HalfSource : public VolumeSource {
 public:
  /// throws: Error kUsage if the source has 32-bit integers or doubles.
  explicit HalfSource(std::unique_ptr<VolumeSource> exact);

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return exact_->order(); }
  /// Values beyond the range of half become its largest value; infinities and NaN stay.
  void read(const VoxelBox& box, std::span<std::byte> out) override;
  void finish() override {
    exact_->finish();
    info_.notes = exact_->info().notes;
  }
  std::uint64_t decodeBytes() const override { return exact_->decodeBytes(); }
  std::uint64_t heldBytes() const override { return exact_->heldBytes(); }
  void keepDecoded(std::uint64_t bytes) override { exact_->keepDecoded(bytes); }

  /// The loss so far. thread: safe.
  HalfLoss loss() const;

 private:
  std::unique_ptr<VolumeSource> exact_;
  SourceInfo info_;
  mutable std::mutex mutex_;
  HalfLoss loss_;
};

}  // namespace kiln
