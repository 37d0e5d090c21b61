#include "frame/background.h"

#include <algorithm>
#include <cmath>

#include "base/thread/parallel.h"

namespace kiln {

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

}  // namespace kiln
