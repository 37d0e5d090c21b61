#include "image/thumbnail_sheet.h"

namespace kiln {
namespace {

constexpr int kGap = 8, kCaption = 16, kTitle = 24;

const glm::dvec3 kPicturePaper{0.16, 0.17, 0.20};

int topOf(const SheetLayout& layout) { return layout.title ? kTitle : kGap / 2; }

}  // namespace

int SheetLayout::sheetWidth() const { return columns * (width + kGap) + kGap; }

int SheetLayout::sheetHeight() const { return topOf(*this) + rows * (kCaption + height + kGap); }

std::uint64_t SheetLayout::bytes() const {
  return 2 * 4 * sizeof(float) * static_cast<std::uint64_t>(sheetWidth()) * static_cast<std::uint64_t>(sheetHeight());
}

ThumbnailSheet::ThumbnailSheet(const SheetLayout& layout, const std::string& title)
    : layout_(layout), plot_(layout.sheetWidth(), layout.sheetHeight(), kSheetPaper) {
  if (layout.title) plot_.text(kGap, kGap, title, kSheetCaption);
}

void ThumbnailSheet::put(int column, int row, const Image& picture, const std::string& caption,
                         const glm::dvec3& caption_srgb) {
  const int x = kGap + column * (layout_.width + kGap);
  const int y = topOf(layout_) + row * (kCaption + layout_.height + kGap);
  plot_.text(x, y + 4, caption, caption_srgb);
  plot_.fill({x, y + kCaption, x + layout_.width, y + kCaption + layout_.height}, kPicturePaper);
  plot_.draw(picture, x, y + kCaption);
}

}  // namespace kiln
