// Texts from outside, such as file names, headers and options: characters, numbers, parts.
#pragma once

#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <vector>

namespace kiln {

/// Replaces capital Latin letters by small letters, in any locale.
std::string lowered(std::string_view text);

/// Returns the number that the whole text is, as std::from_chars reads it; nothing for any other text, or for a number
/// that T cannot hold.
template <class T>
std::optional<T> numberOf(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}
/// Returns the number of an option: as numberOf, but finite, and a whole number without a leading 0, which other
/// programs read as octal.
template <class T>
std::optional<T> decimalOf(std::string_view text) {
  const std::optional<T> value = numberOf<T>(text);
  if constexpr (std::is_integral_v<T>) {
    const std::string_view digits = text.substr(text.starts_with('-') ? 1 : 0);
    return digits.size() > 1 && digits.starts_with('0') ? std::nullopt : value;
  } else {
    return value && std::isfinite(*value) ? value : std::nullopt;
  }
}
/// Returns the parts between separators; the whole text if there is no separator.
std::vector<std::string_view> splitAt(std::string_view text, char separator);

/// Length of the UTF-8 character at the front of a text; 0 if the bytes are no valid character. unit: bytes.
std::size_t bytesOfCharacter(std::string_view text);

/// Escapes control characters (C0, DEL, C1), line separators, bidirectional controls and bytes outside UTF-8 as \n, \t,
/// \xNN or \uNNNN. The result is safe on a terminal and a single line. With `several_lines`, line feeds and tabs stay.
/// Applying the function twice changes nothing.
std::string shown(std::string_view text, bool several_lines = false);
/// Escapes bytes outside UTF-8 as \xNN, and nothing else.
std::string utf8Of(std::string_view text);
/// Escapes bytes of a name as utf8Of. A backslash of the name in front of such an escape becomes \x5c, so that
/// different names stay different.
std::string utf8OfName(std::string_view name);

/// Replaces the characters that `shown` escapes by JSON escapes; values of strings stay equal. requires: valid JSON.
std::string shownInJson(std::string_view json);

}  // namespace kiln
