// Characters of texts from outside, such as file names and headers.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace kiln {

/// Replaces capital Latin letters by small letters, in any locale.
std::string lowered(std::string_view text);

/// Length of the UTF-8 character at the front of a text; 0 if the bytes are no valid character. unit: bytes.
std::size_t bytesOfCharacter(std::string_view text);

/// Escapes control characters (C0, DEL, C1), line separators, bidirectional controls and bytes outside UTF-8 as \n, \t,
/// \xNN or \uNNNN. The result is safe on a terminal and a single line. With `several_lines`, line feeds and tabs stay.
/// Applying the function twice changes nothing.
std::string shown(std::string_view text, bool several_lines = false);
/// Replaces the characters that `shown` escapes by JSON escapes; values of strings stay equal. requires: valid JSON.
std::string shownInJson(std::string_view json);

}  // namespace kiln
