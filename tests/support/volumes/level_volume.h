// A level of a store as a plain volume, for comparison with a picture of this level.
#pragma once

#include "store/store_reader.h"
#include "support/volumes/procedural.h"

namespace kiln::test {

/// throws: all errors of StoreReader::read.
DenseVolume levelVolume(const StoreReader& store, int level);

}  // namespace kiln::test
