#include "support/reference/contact_sheet.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "image/file/image_file.h"

namespace kiln::test {
namespace {

constexpr int kGap = 4;  // unit: pixels

void place(const Image& image, int shrink, int left, int top, Image& sheet) {
  for (int y = 0; y + shrink <= image.height; y += shrink) {
    for (int x = 0; x + shrink <= image.width; x += shrink) {
      float* const out = sheet.pixel(left + x / shrink, top + y / shrink);
      for (int c = 0; c < 3; ++c) {
        float sum = 0;
        for (int i = 0; i < shrink * shrink; ++i) sum += image.pixel(x + i % shrink, y + i / shrink)[c];
        out[c] = sum / static_cast<float>(shrink * shrink);
      }
    }
  }
}

}  // namespace

Image contactSheet(const std::vector<std::vector<Image>>& rows, int cell_px) {
  std::size_t columns = 0;
  for (const auto& row : rows) columns = std::max(columns, row.size());
  Image sheet(static_cast<int>(columns) * (cell_px + kGap) - kGap,
              static_cast<int>(rows.size()) * (cell_px + kGap) - kGap);
  for (std::size_t i = 3; i < sheet.rgba.size(); i += 4) sheet.rgba[i] = 1;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t c = 0; c < rows[r].size(); ++c) {
      const Image& image = rows[r][c];
      const int shrink = (std::max(image.width, image.height) + cell_px - 1) / cell_px;
      place(image, shrink, static_cast<int>(c) * (cell_px + kGap), static_cast<int>(r) * (cell_px + kGap), sheet);
    }
  }
  return sheet;
}

void writeContactSheet(const std::vector<std::vector<Image>>& rows, int cell_px, const std::string& name) {
  const auto file = std::filesystem::path(KILN_TEST_OUTPUT_DIR) / name;
  writeImage(contactSheet(rows, cell_px), {}, {}, file);
  std::printf("%s\n", file.c_str());
}

}  // namespace kiln::test
