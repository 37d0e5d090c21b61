// A value with opacity and colour as text, "VALUE[:OPACITY[:COLOR]]": a surface of `iso:`, or a point of a function.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <string_view>

namespace kiln {

struct ValueText {
  double value;
  std::optional<double> opacity;  // from 0 to 1
  std::optional<glm::dvec3> color;
};

/// Returns nothing for a text of another form, or with a value beyond kLargestValue.
std::optional<ValueText> valueText(std::string_view text);

}  // namespace kiln
