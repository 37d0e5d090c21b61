#include "image/display.h"

#include <algorithm>
#include <cmath>

#include "base/thread/parallel.h"

namespace kiln {

void show(const Display& display, Image& image) {
  if (showsAsDrawn(display)) return;
  const double gain = std::exp2(display.exposure);
  const bool soft = display.tone == Tone::kSoft;
  parallelFor(static_cast<std::size_t>(image.height), [&](std::size_t row) {
    float* pixel = image.pixel(0, static_cast<int>(row));
    for (const float* const end = pixel + 4 * static_cast<std::size_t>(image.width); pixel < end; pixel += 4) {
      if (!(pixel[3] > 0)) continue;
      const double largest = gain * std::max({pixel[0], pixel[1], pixel[2]}) / std::min(pixel[3], 1.0f);
      const double factor = soft && largest > kToneKnee ? gain * (softTone(largest) / largest) : gain;
      for (int channel = 0; channel < 3; ++channel) pixel[channel] = static_cast<float>(pixel[channel] * factor);
    }
  });
}

}  // namespace kiln
