// Finds the line of a value in a JSON text, for errors.
#pragma once

#include <cstddef>
#include <string_view>

namespace kiln {

/// Returns the line, from 1 on, of the value at `place` ("camera.keyframes[2].fov"; "" is the root): the line of its
/// key or list item. If the value is absent, returns the line of the nearest enclosing value. requires: `text` is JSON;
/// comments are allowed.
std::size_t lineOfPlace(std::string_view text, std::string_view place);

}  // namespace kiln
