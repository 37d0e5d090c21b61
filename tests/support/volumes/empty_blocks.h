// Where a ray may step on without looking: blocks of a volume around which the transfer function makes every value
// transparent. A sample that is skipped would have added nothing, so no picture changes by a bit.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <vector>

#include "grid/coords.h"
#include "grid/value_range.h"
#include "scene/transfer/transfer_function.h"

namespace kiln::test {

/// Whether all values of `range` are transparent; true where it is empty. Conservative: a point of the function that
/// lies in the range counts even where another one at the same value overrides it.
bool transparent(const TransferFunction& transfer_function, const ValueRange& range);

class EmptyBlocks {
 public:
  static constexpr std::int64_t kBlock = 4;  // unit: voxels

  /// `voxel` is asked for the voxels (i,j,k) of `dims`, from several threads. Interpolation in a block takes the voxels
  /// up to `reach` beyond it.
  EmptyBlocks(const Extent3& dims, const std::function<double(std::int64_t, std::int64_t, std::int64_t)>& voxel,
              std::int64_t reach, const TransferFunction& transfer_function);

  /// How many further steps of `step` from `index` on are known to add nothing: 0 where `index` itself may add
  /// something, else 1 or more, `index` being the first of them. unit: index space, which is clamped to the volume.
  double stepsToSkip(const glm::dvec3& index, const glm::dvec3& step) const;

 private:
  Extent3 dims_, blocks_;
  std::vector<std::uint8_t> empty_;
};

}  // namespace kiln::test
