// A sheet of pictures of equal size in a grid, each below a caption.
#pragma once

#include <cstdint>
#include <string>

#include "image/image.h"
#include "image/plot_image.h"

namespace kiln {

/// The grid. unit: pixels.
struct SheetLayout {
  int columns = 1, rows = 1;
  int width = 1, height = 1;  // of a picture
  bool title = false;         // a line of text above all

  int sheetWidth() const;
  int sheetHeight() const;
  /// Returns the memory of the sheet, and of pictures that fill it.
  std::uint64_t bytes() const;
};

class ThumbnailSheet {
 public:
  /// `title` is drawn if the layout has one.
  explicit ThumbnailSheet(const SheetLayout& layout, const std::string& title = "");

  /// The colour behind pictures. shape: sRGB.
  static const glm::dvec3& paper();
  /// Draws a picture into a cell, over the cell's paper. requires: a picture of the layout's size, in the grid.
  void put(int column, int row, const Image& picture, const std::string& caption,
           const glm::dvec3& caption_srgb = kSheetInk);
  Image take() && { return std::move(plot_).take(); }

 private:
  const SheetLayout layout_;
  PlotImage plot_;
};

}  // namespace kiln
