// What a conversion would cost, with nothing written: the plan, and what a few bricks say of size and time.
#pragma once

#include "convert/plan.h"

namespace kiln {

struct ConversionCost {
  ConversionPlan plan;
  ReadOrder order = ReadOrder::kAnyBox;
  int levels = 0;
  std::uint64_t bricks = 0;
  /// Bricks of level 0 that were read and encoded.
  std::uint64_t sampled_bricks = 0;
  /// Of a stream, whose voxels come in one order only, the slices that were read, from the first; else 0.
  std::int64_t sampled_slices = 0;
  /// Of all files of the store, as the samples are. unit: bytes.
  std::uint64_t store_bytes = 0;
  /// By the samples.
  double seconds = 0;
};

/// throws: Error kBudget as planConversion, and what the source throws. cost: up to eight bricks read and encoded; of a
/// stream, about two seconds.
ConversionCost conversionCost(VolumeSource& source, const ConvertOptions& options, Progress& progress);

}  // namespace kiln
