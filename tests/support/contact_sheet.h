// Many pictures as one, to be looked at.
#pragma once

#include <vector>

#include "output/image.h"

namespace kiln::test {

/// A row of cells a row, each picture shrunk by means of whole blocks of pixels until it is `cell_px` wide or less, and
/// laid over black. requires: no row is empty.
Image contactSheet(const std::vector<std::vector<Image>>& rows, int cell_px);

}  // namespace kiln::test
