// What lies between two transfer functions.
#pragma once

#include "scene/transfer/transfer_function.h"

namespace kiln {

/// Of each value the opacity at `t` from a's to b's and the colour that both together have, each as much as it is
/// opaque, so that what one function does not show colours nothing. Exact at the points of either and linear between
/// them; opacities are per a's unit. At 0 and 1 it is a or b as they stand. requires: both have a unit above 0.
TransferFunction faded(const TransferFunction& a, const TransferFunction& b, double t);

}  // namespace kiln
