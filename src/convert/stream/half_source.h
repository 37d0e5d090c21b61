// Wraps a source and rounds its values to 16-bit floats: smaller bricks, at a known error.
#pragma once

#include <memory>
#include <mutex>

#include "ingest/source/volume_source.h"

namespace kiln {

/// Rounds voxels of `type` to the nearest half floats; returns the largest change. Infinities and NaN stay.
double roundToHalf(VoxelType type, std::span<std::byte> voxels);

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

  /// The largest change of a value so far. unit: the volume's values. thread: safe.
  double largestError() const;

 private:
  std::unique_ptr<VolumeSource> exact_;
  SourceInfo info_;
  mutable std::mutex mutex_;
  double largest_error_ = 0;
};

}  // namespace kiln
