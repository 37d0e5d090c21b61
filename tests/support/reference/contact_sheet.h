// Many pictures as one, to be looked at.
#pragma once

#include <string>
#include <vector>

#include "image/image.h"

namespace kiln::test {

/// A row of cells a row, each picture shrunk by means of whole blocks of pixels until it is `cell_px` wide or less, and
/// laid over black. requires: no row is empty.
Image contactSheet(const std::vector<std::vector<Image>>& rows, int cell_px);
/// Writes it among the tests' output, and says where. `name` ends in .png.
void writeContactSheet(const std::vector<std::vector<Image>>& rows, int cell_px, const std::string& name);

}  // namespace kiln::test
