// Estimates the cost of a conversion without writing: the plan, and size and time extrapolated from a few bricks.
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
  /// Slices read from the begin of a forward-only stream; else 0.
  std::int64_t sampled_slices = 0;
  /// Estimated size of all files of the store. unit: bytes.
  std::uint64_t store_bytes = 0;
  /// Estimated time, from the samples.
  double seconds = 0;
};

/// throws: Error kBudget as planConversion, and the exceptions of the source. cost: up to eight bricks read and
/// encoded; for a stream, about two seconds.
ConversionCost conversionCost(VolumeSource& source, const ConvertOptions& options, Progress& progress);

}  // namespace kiln
