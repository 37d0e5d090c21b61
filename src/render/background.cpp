#include "render/background.h"

#include <cmath>

namespace kiln {

void layOverBackground(Image& image, int first_row, int rows, const Background& background) {
  if (background == Background{}) return;
  for (int y = 0; y < image.height; ++y) {
    // From the middle of the first row to that of the last.
    const double t = rows > 1 ? static_cast<double>(first_row + y) / (rows - 1) : 0;
    float row[4];
    for (std::size_t channel = 0; channel < 4; ++channel)
      row[channel] = static_cast<float>(std::lerp(background.top[channel], background.bottom[channel], t));
    for (int x = 0; x < image.width; ++x) {
      float* pixel = image.pixel(x, y);
      const float open = 1.0f - pixel[3];
      for (int channel = 0; channel < 4; ++channel) pixel[channel] += open * row[channel];
    }
  }
}

}  // namespace kiln
