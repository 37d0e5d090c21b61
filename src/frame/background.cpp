#include "frame/background.h"

#include <algorithm>
#include <cmath>

#include "base/thread/parallel.h"
#include "image/file/image_file.h"
#include "job/job_facts.h"

namespace kiln {
namespace {

// Rows of ShownRows at a time.
constexpr int kShownRows = 16;

}  // namespace

Background overPaper(Background background, const glm::dvec3& paper) {
  for (auto* const end : {&background.top, &background.bottom}) {
    for (std::size_t channel = 0; channel < 3; ++channel)
      (*end)[channel] += (1 - (*end)[3]) * paper[static_cast<int>(channel)];
    (*end)[3] = 1;
  }
  return background;
}

void layOverBackground(Image& image, int first_row, int rows, const Background& background) {
  if (background == Background{}) return;
  constexpr int kRows = 16;  // rows per task
  parallelFor(static_cast<std::size_t>((image.height + kRows - 1) / kRows), [&](std::size_t chunk) {
    const int first = kRows * static_cast<int>(chunk);
    for (int y = first; y < std::min(first + kRows, image.height); ++y) {
      // The gradient runs from the middle of the first row to the middle of the last.
      const double t = rows > 1 ? static_cast<double>(first_row + y) / (rows - 1) : 0;
      float row[4];
      for (std::size_t channel = 0; channel < 4; ++channel)
        row[channel] = static_cast<float>(std::lerp(background.top[channel], background.bottom[channel], t));
      float* pixel = image.pixel(0, y);
      for (int x = 0; x < image.width; ++x, pixel += 4) {
        const float open = 1.0f - pixel[3];
        for (int channel = 0; channel < 4; ++channel) pixel[channel] += open * row[channel];
      }
    }
  });
}

Medium mediumOf(const std::filesystem::path& picture) { return isExrPath(picture) ? Medium::kLight : Medium::kDisplay; }

Finish finishOf(const PictureOptions& picture, const TransferFunction& transfer_function) {
  if (drawsPart(picture)) return {};
  return {displayOf(picture), backgroundOf(picture, transfer_function), picture.size.height};
}

Background drawnBackground(const PictureOptions& picture, const TransferFunction& transfer_function) {
  if (drawsPart(picture) || !showsAsDrawn(displayOf(picture))) return {};
  return backgroundOf(picture, transfer_function);
}

void finishPicture(Image& image, int first_row, const Finish& finish, Medium medium) {
  if (finish.none()) return;
  if (medium == Medium::kDisplay) show(finish.display, image);
  layOverBackground(image, first_row, finish.rows, finish.background);
}

std::uint64_t ShownRows::bytesFor(int width) {
  return 4 * sizeof(float) * kShownRows * static_cast<std::uint64_t>(width);
}

ShownRows::ShownRows(const Image& image, int first_row, const Finish& finish)
    : ImageRows(image.width, image.height), image_(image), first_row_(first_row), finish_(finish) {}

ImageRows::Band ShownRows::bandAt(int row) {
  if (band_.height == 0 || row < band_row_ || row >= band_row_ + band_.height) {
    const int rows = std::min(kShownRows, height - row);
    if (band_.height != rows) band_ = Image(width, rows);
    std::copy_n(image_.pixel(0, row), band_.rgba.size(), band_.rgba.data());
    band_row_ = row;
    finishPicture(band_, first_row_ + row, finish_, Medium::kDisplay);
  }
  return {&band_, band_row_};
}

std::unique_ptr<ImageRows> shownRows(const Image& image, int first_row, const Finish& finish) {
  if (finish.none()) return std::make_unique<RowsOfImage>(image);
  return std::make_unique<ShownRows>(image, first_row, finish);
}

}  // namespace kiln
