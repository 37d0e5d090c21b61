// The colours of slices: colours of labels, or a window of values in grey or in the colours of a map.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "scene/transfer/transfer_function.h"

namespace kiln {

/// The colours of a map in equal steps, in linear light. A step is a quarter of a step of an 8-bit picture.
class SlicePalette {
 public:
  /// The window reaches from the first colour to the last. throws: Error kUsage (map, window).
  SlicePalette(const std::string& map, const Window& window);

  /// Returns the colour of a value; null for NaN.
  const glm::vec3* of(double value) const;

 private:
  static constexpr std::size_t kSteps = 1024;
  Window window_;
  std::array<glm::vec3, kSteps> colors_;
};

/// The colour of each value of a slice.
class SliceColors {
 public:
  /// If there are `labels`, which are sorted, their colours replace map and window. throws: as SlicePalette.
  SliceColors(const std::vector<LabelStyle>& labels, const std::string& map, const Window& window);

  /// Returns the colour of a value; null for NaN, and for a label without opacity or style.
  const glm::vec3* of(double value) const;

 private:
  std::optional<SlicePalette> palette_;
  std::vector<double> labels_;
  std::vector<std::optional<glm::vec3>> colors_;
};

}  // namespace kiln
