#include "say.h"

#include <cstdio>

namespace kiln::tool {
namespace {

std::FILE* report = stdout;

void write(std::string_view text, std::FILE* file) { std::fwrite(text.data(), 1, text.size(), file); }

}  // namespace

void sayLines(std::string_view text) { write(shown(text, true), report); }

void sayJson(std::string_view text) { write(shownInJson(text), report); }

void flush() { std::fflush(report); }

void sayToStandardError() { report = stderr; }

void complainPlainly(const char* sentence) noexcept { std::fprintf(stderr, "kiln: %s\n", sentence); }

void drawLine(std::string_view line, std::size_t columns) {
  std::string text = shown(line);
  if (text.size() > columns) {
    // No part of a character.
    while (columns > 0 && (static_cast<unsigned char>(text[columns]) & 0xc0) == 0x80) --columns;
    text.resize(columns);
  }
  write("\r\033[K" + text, stderr);
  std::fflush(stderr);
}

void clearLine() { write("\r\033[K", stderr); }

void detail::print(std::string_view text, bool as_error) { write(text, as_error ? stderr : report); }

}  // namespace kiln::tool
