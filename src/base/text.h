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

/// The text with control characters (C0, DEL, C1), line separators, bidirectional controls and bytes outside UTF-8 as
/// \n, \t, \xNN or \uNNNN: safe on a terminal, and a single line. With `several_lines`, line feeds and tabs stay. A
/// text that was shown before is returned unchanged.
std::string shown(std::string_view text, bool several_lines = false);
/// JSON with the characters that `shown` escapes as escapes of JSON: the values of strings are unchanged. requires: the
/// text is JSON.
std::string shownInJson(std::string_view json);

}  // namespace kiln
