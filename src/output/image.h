// A finished picture in memory: linear light, premultiplied alpha.
#pragma once

#include <cstddef>
#include <vector>

namespace kiln {

/// shape: height rows of width pixels of 4 floats R G B A, row 0 at the top. unit: linear, premultiplied.
struct Image {
  int width = 0, height = 0;
  std::vector<float> rgba;

  Image() = default;
  Image(int w, int h) : width(w), height(h), rgba(static_cast<std::size_t>(w) * h * 4) {}
  float* pixel(int x, int y) { return rgba.data() + (static_cast<std::size_t>(y) * width + x) * 4; }
  const float* pixel(int x, int y) const { return rgba.data() + (static_cast<std::size_t>(y) * width + x) * 4; }
};

}  // namespace kiln
