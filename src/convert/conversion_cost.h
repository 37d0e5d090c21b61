// What a conversion would cost, with nothing written: the plan, and what a few bricks say of size and time.
#pragma once

#include <optional>

#include "convert/plan.h"

namespace kiln {

struct ConversionCost {
  ConversionPlan plan;
  ReadOrder order = ReadOrder::kAnyBox;
  int levels = 0;
  std::uint64_t bricks = 0;
  /// Bricks of level 0 that were read and encoded; 0 for a stream, whose voxels come in one order only.
  std::uint64_t sampled_bricks = 0;
  /// Of all files of the store. Where no brick was sampled, the most that it can be. unit: bytes.
  std::uint64_t store_bytes = 0;
  /// The most that lies beside these until the store is finished: slices of a stream, what bricks give to coarser
  /// levels. unit: bytes.
  std::uint64_t scratch_bytes = 0;
  /// By the sampled bricks; empty where there are none.
  std::optional<double> seconds;
};

/// throws: Error kBudget as planConversion, and what the source throws. cost: up to eight bricks read and encoded.
ConversionCost conversionCost(VolumeSource& source, const ConvertOptions& options, Progress& progress);

}  // namespace kiln
