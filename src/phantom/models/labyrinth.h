// A labyrinth of sheets that resembles the grooves of the brain: the zero set of the gyroid sin x cos y + sin y cos z +
// sin z cos x.
// Differs: parabolas replace the sines, so every machine computes equal bits.
// Source: A. Schoen, "Infinite periodic minimal surfaces without self-intersections", 1970.
#pragma once

#include <algorithm>
#include <cmath>

#include "phantom/models/figure.h"

namespace kiln::phantom {

class Labyrinth {
 public:
  explicit Labyrinth(const Folds& folds)
      : depth_(static_cast<float>(folds.depth_mm)),
        half_width_(static_cast<float>(folds.half_width_mm)),
        waves_per_mm_(static_cast<float>(1 / folds.period_mm)),
        // The gradient of the gyroid at its zero set is about 1.5 per radian.
        mm_per_unit_(static_cast<float>(folds.period_mm / (2 * 3.14159265 * 1.5))) {}

  /// Returns the distance `d` to a surface after cutting the sheets into it, down to the depth of the folds.
  float cut(float d, float x, float y, float z) const {
    const float u = x * waves_per_mm_, v = y * waves_per_mm_, w = z * waves_per_mm_;
    const float gyroid = sine(u) * sine(v + 0.25f) + sine(v) * sine(w + 0.25f) + sine(w) * sine(u + 0.25f);
    const float sheet = std::abs(gyroid) * mm_per_unit_ - half_width_;
    return std::max(d, -std::max(sheet, -d - depth_));
  }

 private:
  // A wave of period 1.
  static float sine(float turns) {
    // Truncation rounds down because the argument is positive: a figure lies within a thousand waves of its origin.
    const float shifted = turns + 1024.5f;
    const float t = 2 * (shifted - static_cast<float>(static_cast<int>(shifted))) - 1;
    return 4 * t * (1 - std::abs(t));
  }

  float depth_, half_width_, waves_per_mm_, mm_per_unit_;
};

}  // namespace kiln::phantom
