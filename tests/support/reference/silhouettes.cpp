#include "support/reference/silhouettes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace kiln::test {
namespace {

bool farApart(double a, double b, double jump) {
  if (std::isinf(a) || std::isinf(b)) return std::isinf(a) != std::isinf(b);
  return std::abs(a - b) > jump;
}

}  // namespace

std::vector<bool> silhouetteBand(const Image& picture, const std::vector<double>& depth, double jump) {
  const int width = picture.width, height = picture.height;
  const auto at = [&](int x, int y) { return static_cast<std::size_t>(y) * width + x; };
  std::vector<bool> edge(at(0, height)), out(edge.size());
  const auto parted = [&](std::size_t a, std::size_t b) {
    return (picture.rgba[4 * a + 3] > 0.5f) != (picture.rgba[4 * b + 3] > 0.5f) || farApart(depth[a], depth[b], jump);
  };
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      if (x + 1 < width && parted(at(x, y), at(x + 1, y))) edge[at(x, y)] = edge[at(x + 1, y)] = true;
      if (y + 1 < height && parted(at(x, y), at(x, y + 1))) edge[at(x, y)] = edge[at(x, y + 1)] = true;
    }
  }
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v) {
        for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u)
          if (edge[at(u, v)]) out[at(x, y)] = true;
      }
    }
  }
  return out;
}

double psnrWithin(const std::vector<bool>& band, const Image& a, const Image& b) {
  double sum = 0;
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < band.size(); ++i) {
    if (!band[i]) continue;
    ++pixels;
    for (std::size_t c = 0; c < 3; ++c) {
      const double d = static_cast<double>(a.rgba[4 * i + c]) - b.rgba[4 * i + c];
      sum += d * d;
    }
  }
  return sum > 0 ? -10 * std::log10(sum / (3 * static_cast<double>(pixels))) : std::numeric_limits<double>::infinity();
}

}  // namespace kiln::test
