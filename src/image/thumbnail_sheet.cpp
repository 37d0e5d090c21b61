#include "image/thumbnail_sheet.h"

namespace kiln {
namespace {

constexpr int kCellGap = 8, kCaption = 16, kTitleHeight = 24;

const glm::dvec3 kPicturePaper{0.16, 0.17, 0.20};

int topOf(const SheetLayout& layout) { return layout.title ? kTitleHeight : kCellGap / 2; }

}  // namespace

int SheetLayout::sheetWidth() const { return columns * (width + kCellGap) + kCellGap; }

int SheetLayout::sheetHeight() const { return topOf(*this) + rows * (kCaption + height + kCellGap); }

std::uint64_t SheetLayout::bytes() const {
  return 2 * 4 * sizeof(float) * static_cast<std::uint64_t>(sheetWidth()) * static_cast<std::uint64_t>(sheetHeight());
}

ThumbnailSheet::ThumbnailSheet(const SheetLayout& layout, const std::string& title)
    : layout_(layout), plot_(layout.sheetWidth(), layout.sheetHeight(), kSheetPaper) {
  if (layout.title) plot_.text(kCellGap, kCellGap, title, kSheetCaption);
}

const glm::dvec3& ThumbnailSheet::paper() { return kPicturePaper; }

void ThumbnailSheet::put(int column, int row, const Image& picture, const std::string& caption,
                         const glm::dvec3& caption_srgb) {
  const int x = kCellGap + column * (layout_.width + kCellGap);
  const int y = topOf(layout_) + row * (kCaption + layout_.height + kCellGap);
  plot_.text(x, y + 4, caption, caption_srgb);
  plot_.fill({x, y + kCaption, x + layout_.width, y + kCaption + layout_.height}, kPicturePaper);
  plot_.draw(picture, x, y + kCaption);
}

}  // namespace kiln
