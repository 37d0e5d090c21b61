// All text of the program on standard output and standard error, but for help, is printed here. Names of files, units,
// labels and comments may hold any bytes. Characters with an effect on a terminal, or on the order of a line, are
// printed as escapes.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

#include "base/text.h"

namespace kiln::tool {

/// Prints to standard output; after sayToStandardError, to standard error. Text arguments are `shown`; the format is
/// printed unchanged.
template <class... Args>
void say(fmt::format_string<Args...> format, Args&&... args);
/// Prints a text of several lines, `shown`, where `say` prints.
void sayLines(std::string_view text);
/// Prints JSON where `say` prints. Characters escaped by `shown` become escapes of JSON: the values of strings are
/// unchanged. requires: the text is JSON.
void sayJson(std::string_view text);
/// Flushes standard output.
void flush();
/// Prints all further text of the command to standard error, because one of its files is standard output.
void sayToStandardError();

/// Prints to standard error, as `say`.
template <class... Args>
void complain(fmt::format_string<Args...> format, Args&&... args);
/// Prints a sentence of the program's own to standard error without memory. requires: no text of a file or name.
void complainPlainly(const char* sentence) noexcept;
/// Draws a line over the last line of a terminal, cut to `columns` bytes; `clearLine` removes the line.
void drawLine(std::string_view line, std::size_t columns);
void clearLine();

namespace detail {
void print(std::string_view text, bool as_error);

template <class T>
decltype(auto) shownArgument(const T& argument) {
  if constexpr (std::is_convertible_v<const T&, std::string_view>)
    return shown(std::string_view(argument));
  else
    return static_cast<const T&>(argument);
}

template <class... Args>
std::string formatted(std::string_view format, const Args&... args) {
  const std::tuple<std::decay_t<decltype(shownArgument(args))>...> all(shownArgument(args)...);
  return std::apply([&](const auto&... each) { return fmt::vformat(format, fmt::make_format_args(each...)); }, all);
}
}  // namespace detail

template <class... Args>
void say(fmt::format_string<Args...> format, Args&&... args) {
  const fmt::string_view text = format;
  detail::print(detail::formatted({text.data(), text.size()}, args...), false);
}

template <class... Args>
void complain(fmt::format_string<Args...> format, Args&&... args) {
  const fmt::string_view text = format;
  detail::print(detail::formatted({text.data(), text.size()}, args...), true);
}

}  // namespace kiln::tool
