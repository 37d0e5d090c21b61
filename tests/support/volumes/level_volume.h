// A level of a store as a plain volume: what a picture of that level is judged against.
#pragma once

#include "store/store_reader.h"
#include "support/volumes/procedural.h"

namespace kiln::test {

/// throws: what StoreReader::read throws.
DenseVolume levelVolume(const StoreReader& store, int level);

}  // namespace kiln::test
