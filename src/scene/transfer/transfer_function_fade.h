// Interpolates between two transfer functions.
#pragma once

#include "scene/transfer/transfer_function.h"

namespace kiln {

/// For each value: opacity at `t` between a's and b's; colours weighted by opacity, so that transparent values add no
/// colour. Exact at the points of either function and linear between them; opacities are per a's unit. At 0 and 1 the
/// result is a or b unchanged. requires: both units are above 0.
TransferFunction faded(const TransferFunction& a, const TransferFunction& b, double t);

/// Returns whether all regions of both functions are in the functions between them.
bool regionsFade(const TransferFunction& a, const TransferFunction& b);

}  // namespace kiln
