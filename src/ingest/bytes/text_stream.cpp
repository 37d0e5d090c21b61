// Each value must fit its type exactly as a whole number, and is rounded once as a float.
#include "ingest/bytes/text_stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>

#include "base/error.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

constexpr std::size_t kLongestNumber = 400;

bool isBlank(int c) { return c == ' ' || (c >= '\t' && c <= '\r') || c == ','; }

// Returns a number with a negative exponent, with an exponent that a long double holds; else the text.
std::string withinRange(std::string_view text) {
  const std::size_t exponent = text.find_first_of("eE");
  const bool negative = exponent != std::string_view::npos && text.substr(exponent + 1).starts_with('-');
  const std::string_view digits = negative ? text.substr(exponent + 2) : std::string_view();
  if (digits.size() < 4 || !std::ranges::all_of(digits, [](char c) { return c >= '0' && c <= '9'; }))
    return std::string(text);
  // Below each type's least number, whatever the up to kLongestNumber digits in front.
  return std::string(text.substr(0, exponent)) + "e-4000";
}

template <class T>
std::optional<T> valueOf(std::string_view text) {
  if constexpr (std::is_floating_point_v<T>) {
    if (const auto value = signedNumberOf<T>(text)) return value;
    // A number too small for the type is 0, as for scanf.
    const std::optional<long double> small = signedNumberOf<long double>(withinRange(text));
    return small && std::abs(*small) < 1 ? std::optional(static_cast<T>(*small)) : std::nullopt;
  } else {
    const auto whole = signedNumberOf<std::int64_t>(text);
    if (!whole || *whole < std::numeric_limits<T>::min() || *whole > std::numeric_limits<T>::max()) return std::nullopt;
    return static_cast<T>(*whole);
  }
}

int digitOf(int c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

}  // namespace

int TextStream::peek() {
  if (at_ == buffer_.size()) {
    offset_bytes_ += buffer_.size();
    buffer_.resize(kBufferBytes);
    buffer_.resize(file_.readSomeAt(offset_bytes_, buffer_));
    at_ = 0;
    if (buffer_.empty()) return -1;
  }
  return std::to_integer<int>(buffer_[at_]);
}

void TextStream::skipBlanks() {
  while (isBlank(peek())) take();
}

void TextStream::fail(const std::string& where, const std::string& what) const {
  throw Error(ErrorCode::kFormat, file_.path(), fmt::format("byte {}, {}", offset_bytes_ + at_, where), what);
}

std::vector<std::string> TextStream::finish() {
  skipBlanks();
  if (peek() < 0) return {};
  return {fmt::format("{}: text behind the header's dimensions not read, from byte {} on",
                      file_.path().filename().string(), offset_bytes_ + at_)};
}

std::string_view DecimalStream::word(const std::string& where) {
  skipBlanks();
  word_.clear();
  for (int c = peek(); c >= 0 && c != '<' && !isBlank(c); c = peek()) {
    if (word_.size() == kLongestNumber) fail(where, inQuotes(word_) + " is too long to be a number");
    word_ += static_cast<char>(c);
    take();
  }
  if (word_.empty())
    fail(where,
         "the numbers end here, before the last voxel; the header's dimensions are too large or data are missing");
  return word_;
}

void DecimalStream::read(std::span<std::byte> out, const std::string& where) {
  withVoxelType(type_, [&]<class T>(std::type_identity<T>) {
    for (std::size_t at = 0; at < out.size(); at += sizeof(T)) {
      const std::string_view text = word(where);
      const std::optional<T> value = valueOf<T>(text);
      if (!value) fail(where, fmt::format("{} is not a value of type {}", inQuotes(text), nameOf(type_)));
      std::memcpy(out.data() + at, &*value, sizeof(T));
    }
  });
}

// A text that is cut inside its last number still ends with a number.
std::vector<std::string> DecimalStream::finish() {
  if (peek() >= 0) return TextStream::finish();
  return {file().path().filename().string() +
          ": the text ends with a digit and no line end; its last number may be cut short"};
}

void ShareStream::read(std::span<std::byte> out, const std::string& where) {
  for (std::byte& byte : out) {
    const std::string_view text = word(where);
    const std::optional<double> share = valueOf<double>(text);
    if (!share || !(*share >= 0 && *share <= 1)) fail(where, inQuotes(text) + " is not a share from 0 to 1");
    byte = static_cast<std::byte>(std::lround(255 * *share));
  }
}

void HexStream::read(std::span<std::byte> out, const std::string& where) {
  const auto digit = [&] {
    skipBlanks();
    const int found = digitOf(peek());
    if (found < 0) fail(where, peek() < 0 ? "the digits end here, before the last voxel" : "is no hexadecimal digit");
    take();
    return found;
  };
  for (std::byte& byte : out) {
    const int high = digit();
    byte = static_cast<std::byte>(high << 4 | digit());
  }
}

}  // namespace kiln
