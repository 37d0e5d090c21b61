// A contact sheet: many pictures in a single image, for inspection.
#pragma once

#include <string>
#include <vector>

#include "image/image.h"

namespace kiln::test {

/// Lays cells out row by row. Each picture is shrunk by averaging whole blocks of pixels until at most `cell_px` wide,
/// and composited over black. requires: no row is empty.
Image contactSheet(const std::vector<std::vector<Image>>& rows, int cell_px);
/// Writes the sheet to the tests' output folder and prints its path. `name` ends in .png.
void writeContactSheet(const std::vector<std::vector<Image>>& rows, int cell_px, const std::string& name);

}  // namespace kiln::test
