// Finds the line of a value in a JSON text, for errors.
#pragma once

#include <cstddef>
#include <string_view>

namespace kiln {

/// The line, from 1 on, of the value that `place` ("camera.keyframes[2].fov", "" for the root) names: of its key, or of
/// the item of a list. Where it is not there, that of what should hold it. requires: `text` is JSON; comments are
/// allowed.
std::size_t lineOfPlace(std::string_view text, std::string_view place);

}  // namespace kiln
