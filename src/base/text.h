// Characters of texts from elsewhere: file names, headers.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace kiln {

/// With small Latin letters for capital ones, whatever the locale.
std::string lowered(std::string_view text);

/// Of a character in UTF-8 at the front of a text, its bytes; 0 where there is none.
std::size_t bytesOfCharacter(std::string_view text);

}  // namespace kiln
