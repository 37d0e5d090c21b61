// Empty blocks of a volume: the transfer function makes every value around the block transparent. Skipped samples would
// add nothing, so the picture does not change by a bit.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "grid/coords.h"
#include "grid/value_range.h"
#include "scene/transfer/transfer_function.h"

namespace kiln::test {

/// Returns true if all values of `range` are transparent, or if the range is empty. Conservative: every point of the
/// function inside the range counts, even if overridden by a point at an equal value.
bool transparent(const TransferFunction& transfer_function, const ValueRange& range);

class EmptyBlocks {
 public:
  static constexpr std::int64_t kBlock = 4;  // unit: voxels

  /// `voxel` is called for the voxels (i,j,k) of `dims`, from several threads. Interpolation in a block reads voxels up
  /// to `reach` beyond the block.
  EmptyBlocks(const Extent3& dims, const std::function<double(std::int64_t, std::int64_t, std::int64_t)>& voxel,
              std::int64_t reach, const TransferFunction& transfer_function);

  /// Returns the number of further steps of `step` from `index` on that add nothing: 0 if `index` itself may add
  /// something, else 1 or more, including `index`. unit: index space, clamped to the volume.
  double stepsToSkip(const glm::dvec3& index, const glm::dvec3& step) const;

 private:
  Extent3 dims_, blocks_;
  std::vector<std::uint8_t> empty_;
};

}  // namespace kiln::test
