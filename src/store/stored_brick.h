// The name of a brick among the bricks of several stores.
#pragma once

#include "grid/coords.h"

namespace kiln {

/// A brick of one of several stores.
struct StoredBrick {
  BrickKey key;
  int store = 0;  // index of the store among the stores
  auto operator<=>(const StoredBrick&) const = default;
};

}  // namespace kiln
