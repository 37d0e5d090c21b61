#include "base/text.h"

#include <fmt/format.h>

namespace kiln {
namespace {

// Returns the Unicode code point of a character that is `bytes` bytes long (bytesOfCharacter).
unsigned codePoint(std::string_view text, std::size_t bytes) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  if (bytes == 1) return byte(0);
  unsigned out = byte(0) & (0xffu >> (bytes + 1));
  for (std::size_t i = 1; i < bytes; ++i) out = out << 6 | (byte(i) & 0x3fu);
  return out;
}

// True for characters that control a terminal, change the order of a line, or break lines.
bool isUnsafe(unsigned c) {
  return c < 0x20 || (c >= 0x7f && c <= 0x9f) || c == 0x061c || c == 0x200e || c == 0x200f ||
         (c >= 0x2028 && c <= 0x202e) || (c >= 0x2066 && c <= 0x2069);
}

std::string escapedByte(unsigned byte) { return fmt::format("\\x{:02x}", byte); }

// Calls `plain` with the bytes of each safe or kept character. For each unsafe character calls `unsafe` with its code
// point and false; for each byte outside UTF-8, with the byte and true.
template <class Keeps, class Plain, class Unsafe>
void eachCharacter(std::string_view text, const Keeps& keeps, const Plain& plain, const Unsafe& unsafe) {
  while (!text.empty()) {
    const std::size_t bytes = bytesOfCharacter(text);
    if (bytes == 0) {
      unsafe(static_cast<unsigned char>(text.front()), true);
      text.remove_prefix(1);
      continue;
    }
    const unsigned c = codePoint(text, bytes);
    if (isUnsafe(c) && !keeps(c))
      unsafe(c, false);
    else
      plain(text.substr(0, bytes));
    text.remove_prefix(bytes);
  }
}

}  // namespace

std::string lowered(std::string_view text) {
  std::string out(text);
  for (char& c : out) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return out;
}

std::vector<std::string_view> splitAt(std::string_view text, char separator) {
  std::vector<std::string_view> out;
  for (std::size_t begin = 0; begin <= text.size(); begin += out.back().size() + 1)
    out.push_back(text.substr(begin, text.substr(begin).find(separator)));
  return out;
}

std::size_t bytesOfCharacter(std::string_view text) {
  if (text.empty()) return 0;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(0);
  if (first < 0x80) return 1;
  const std::size_t count = first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
  if (first < 0xc2 || first > 0xf4 || count > text.size()) return 0;
  for (std::size_t i = 1; i < count; ++i)
    if ((byte(i) & 0xc0) != 0x80) return 0;
  // Second bytes below `least` make an overlong form (e0, f0). Second bytes above `most` make half a surrogate pair
  // (ed) or exceed Unicode (f4).
  const unsigned char least = first == 0xe0 ? 0xa0 : first == 0xf0 ? 0x90 : 0x80;
  const unsigned char most = first == 0xed ? 0x9f : first == 0xf4 ? 0x8f : 0xbf;
  return byte(1) >= least && byte(1) <= most ? count : 0;
}

std::string shown(std::string_view text, bool several_lines) {
  std::string out;
  eachCharacter(
      text, [&](unsigned c) { return several_lines && (c == '\n' || c == '\t'); },
      [&](std::string_view character) { out += character; },
      [&](unsigned c, bool is_byte) {
        const char* const known = is_byte     ? nullptr
                                  : c == '\n' ? "\\n"
                                  : c == '\t' ? "\\t"
                                  : c == '\r' ? "\\r"
                                              : nullptr;
        out += known != nullptr ? known : is_byte || c < 0x100 ? escapedByte(c) : fmt::format("\\u{:04x}", c);
      });
  return out;
}

std::string utf8Of(std::string_view text) {
  std::string out;
  eachCharacter(
      text, [](unsigned) { return true; }, [&](std::string_view character) { out += character; },
      [&](unsigned byte, bool) { out += escapedByte(byte); });
  return out;
}

std::string utf8OfName(std::string_view name) {
  const auto isHex = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F'); };
  std::string out;
  for (; !name.empty(); name.remove_prefix(1)) {
    const bool escape = name.size() >= 4 && name.starts_with("\\x") && isHex(name[2]) && isHex(name[3]);
    if (escape)
      out += escapedByte('\\');
    else
      out += name.front();
  }
  return utf8Of(out);
}

std::string shownInJson(std::string_view json) {
  std::string out;
  eachCharacter(
      json, [](unsigned c) { return c == '\n' || c == '\t' || c == '\r'; },
      [&](std::string_view character) { out += character; },
      [&](unsigned c, bool is_byte) { out += is_byte ? "\\ufffd" : fmt::format("\\u{:04x}", c); });
  return out;
}

}  // namespace kiln
