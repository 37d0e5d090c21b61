// The marker of directions.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "annotate/drawing.h"

namespace kiln {

/// Length of a direction that runs in the plane of the picture. unit: the font's size.
inline constexpr double kArmLength = 2;
/// From the end of a direction to the middle of its letter. unit: the font's size.
inline constexpr double kLetterGap = 0.6;

struct Direction {
  std::string_view name;
  int axis;         // axis of the world
  glm::dvec3 seen;  // in view space: x right, y down, z away from the eye. Unit length
};
/// Returns the directions with names, the farthest from the eye first.
std::vector<Direction> directionsOf(const AnnotatedPicture& picture);
/// The point where the directions begin. unit: pixels.
glm::dvec2 middleOfDirections(const AnnotatedPicture& picture, const Style& style);
/// Returns the middles of the directions' letters; nothing for a letter that is left out. A letter that would lie over
/// the letter of a direction nearer to the eye stands beside it. unit: pixels.
std::vector<std::optional<glm::dvec2>> letterPlaces(const AnnotatedPicture& picture,
                                                    const std::vector<Direction>& directions, const Style& style);

}  // namespace kiln
