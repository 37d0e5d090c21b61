// Interval of values that classification resolves. A single extreme value, such as a file's fill value (-3.4e38, 1e30),
// must not cost the precision of all ordinary values.
#pragma once

#include <algorithm>

#include "grid/value_range.h"
#include "scene/transfer/transfer_function.h"

namespace kiln {

/// Returns the values that a table of the function must cover. Normally all of `range`. If the function's points span
/// less than 1/512 of the range, the interval is 128 spans on both sides of the points; the function is constant beyond
/// its points.
inline ValueRange classifiedRange(const TransferFunction& function, const ValueRange& range) {
  constexpr double kSmallPart = 1.0 / 512, kBeside = 128;
  if (range.empty() || function.points.empty()) return range;
  const double first = function.points.front().value, last = function.points.back().value, span = last - first;
  if (!(span > 0) || !(span < kSmallPart * (range.hi - range.lo))) return range;
  const ValueRange out{std::max(range.lo, first - kBeside * span), std::min(range.hi, last + kBeside * span)};
  // The range and the points are disjoint: all values have the colour of one end of the function.
  return out.lo < out.hi ? out : ValueRange{first, last};
}

}  // namespace kiln
