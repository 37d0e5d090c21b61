// Which of a volume's values a transfer function tells apart. A voxel that is far beyond all others, such as the number
// that a file has where it knows nothing (-3.4e38, 1e30), must not cost those their digits.
#pragma once

#include <algorithm>

#include "grid/value_range.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

/// The values of `range` that a table of the function covers: all of them; but where its points span less than a 512th,
/// as much as 128 times their span to both sides of them. Beyond its points the function is constant.
inline ValueRange classifiedRange(const TransferFunction& function, const ValueRange& range) {
  constexpr double kSmallPart = 1.0 / 512, kBeside = 128;
  if (range.empty() || function.points.empty()) return range;
  const double first = function.points.front().value, last = function.points.back().value, span = last - first;
  if (!(span > 0) || !(span < kSmallPart * (range.hi - range.lo))) return range;
  const ValueRange out{std::max(range.lo, first - kBeside * span), std::min(range.hi, last + kBeside * span)};
  // Of a volume none of whose values are near them, either end says what all of them look like.
  return out.lo < out.hi ? out : ValueRange{first, last};
}

}  // namespace kiln
