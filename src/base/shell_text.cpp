#include "base/shell_text.h"

namespace kiln {

std::string shellText(std::string_view argument) {
  constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:@%#";
  // A word that begins with # is a comment. Bytes outside ASCII are letters of names.
  const auto isPlain = [&](char c) { return kPlain.find(c) != std::string_view::npos || c < 0; };
  bool plain = !argument.empty() && argument.front() != '#';
  for (const char c : argument) plain = plain && isPlain(c);
  if (plain) return std::string(argument);
  std::string out = "'";
  for (const char c : argument) {
    if (c == '\'')
      out += "'\\''";
    else
      out += c;
  }
  return out + "'";
}

}  // namespace kiln
