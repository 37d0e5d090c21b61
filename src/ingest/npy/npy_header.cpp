// Magic, version, length, then a Python dictionary as text: {'descr': '<u2', 'fortran_order': False, 'shape': (3, 4,
// 5)}. Nothing is evaluated: the three keys, strings, truth values and a tuple of whole numbers are all that is parsed.
// The length of the header is checked before memory is reserved for it. Source:
// numpy.org/doc/stable/reference/generated/numpy.lib.format.html.
#include "ingest/npy/npy_header.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <optional>
#include <string>
#include <string_view>

#include "base/error.h"
#include "ingest/bytes/numpy_type.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

constexpr std::string_view kNpyMagic = "\x93NUMPY";
constexpr std::size_t kVersionBytes = 2;
// Most bytes of a header of version 1.0. Only records of many fields, which are not read, have longer headers.
constexpr std::uint64_t kMostNpyBytes = 65535;
// NPY_MAXDIMS of NumPy 2.
constexpr std::size_t kMostNpyAxes = 64;

/// Reads the dictionary from its first byte to its last; every error names the byte of the file.
class NpyDictionary {
 public:
  NpyDictionary(const File& file, std::uint64_t offset, std::string_view text)
      : file_(file), offset_(offset), text_(text) {}

  /// Skips spaces, and `wanted` if it is the next character.
  bool accept(char wanted) {
    skipSpaces();
    if (at_ == text_.size() || text_[at_] != wanted) return false;
    ++at_;
    return true;
  }
  void expect(char wanted) {
    if (!accept(wanted)) failHere(fmt::format("'{}' is expected", wanted));
  }
  void expectEnd() {
    skipSpaces();
    if (at_ < text_.size()) failHere("only spaces are expected behind the dictionary");
  }

  std::string_view string();
  bool truth();
  std::vector<std::int64_t> tuple();

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kFormat, file_.path(), fmt::format("byte {}", offset_ + at_), what);
  }

 private:
  std::string_view rest() const { return text_.substr(at_); }
  void skipSpaces() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos) ++at_;
  }
  bool acceptWord(std::string_view word) {
    if (!rest().starts_with(word)) return false;
    at_ += word.size();
    return true;
  }
  [[noreturn]] void failHere(const std::string& what) const {
    fail(rest().empty() ? what + " (the header ends here)"
                        : fmt::format("{} (found {})", what, inQuotes(rest().substr(0, 12))));
  }
  std::int64_t wholeNumber();

  const File& file_;
  std::uint64_t offset_;
  std::string_view text_;
  std::size_t at_ = 0;
};

// Keys and types have no escapes, so a backslash is a character like any other and makes an unknown name.
std::string_view NpyDictionary::string() {
  const char quote = accept('"') ? '"' : '\'';
  if (quote == '\'' && !accept('\'')) failHere("a text in quotation marks is expected");
  const std::size_t length = rest().find(quote);
  if (length == std::string_view::npos) failHere("the text has no end");
  const std::string_view out = rest().substr(0, length);
  at_ += length + 1;
  return out;
}

bool NpyDictionary::truth() {
  skipSpaces();
  if (acceptWord("True")) return true;
  if (!acceptWord("False")) failHere("True or False is expected");
  return false;
}

std::int64_t NpyDictionary::wholeNumber() {
  skipSpaces();
  std::int64_t value = 0;
  const std::string_view digits = rest();
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc{} || value < 0) failHere("a whole number from 0 to 2^63 - 1 is expected");
  at_ += static_cast<std::size_t>(end - digits.data());
  acceptWord("L");  // NumPy under Python 2 wrote (62L, 112L, 128L)
  return value;
}

std::vector<std::int64_t> NpyDictionary::tuple() {
  std::vector<std::int64_t> out;
  expect('(');
  while (!accept(')')) {
    if (out.size() == kMostNpyAxes) fail(fmt::format("an array has at most {} axes", kMostNpyAxes));
    out.push_back(wholeNumber());
    if (accept(',')) continue;
    expect(')');
    break;
  }
  return out;
}

// Describes elements that are not read, with the way out.
std::string_view unreadType(std::string_view code) {
  if (code == "b1") return "truth values, which Kiln does not read; save the array as uint8";
  switch (code.empty() ? ' ' : code.front()) {
    case 'f':
      return "floats of a size that Kiln does not read; save the array as float64";
    case 'c':
      return "complex numbers; save the real part or the magnitude";
    case 'O':
      return "Python objects, which Kiln does not read; save the array as numbers";
    case 'V':
      return "records or opaque bytes; save one number a voxel";
    default:
      return "elements that are not numbers known to Kiln; save the array as integers or floats of 8 to 64 bits";
  }
}

void takeType(const File& file, std::string_view descr, NpyHeader& header) {
  const auto [order, code] = numpyTypeText(descr);
  const std::optional<StoredType> type = numpyTypeOf(code);
  if (!type)
    throw Error(ErrorCode::kUnsupported, file.path(), "descr",
                fmt::format("{}: {}", inQuotes(descr), unreadType(code)));
  // An order relative to the writer's machine is unknown here.
  if (order != '<' && order != '>' && sizeOf(*type) > 1)
    throw Error(ErrorCode::kFormat, file.path(), "descr",
                fmt::format("{} has no byte order; < or > is expected before the type", inQuotes(descr)));
  header.type = *type;
  header.big_endian = order == '>';
}

// Returns the dictionary's text; `begin` becomes its first byte.
std::string readText(const File& file, std::uint64_t& begin) {
  std::array<std::byte, kNpyMagic.size() + kVersionBytes> start{};
  file.readAt(0, start);
  const std::span<const std::byte> magic = std::span(start).first(kNpyMagic.size());
  if (!std::equal(magic.begin(), magic.end(), bytesOf(kNpyMagic).begin()))
    throw Error(ErrorCode::kFormat, file.path(), "byte 0",
                "the file does not begin with \\x93NUMPY; not a NumPy array");
  const int major = std::to_integer<int>(start[kNpyMagic.size()]),
            minor = std::to_integer<int>(start[kNpyMagic.size() + 1]);
  if (major < 1 || major > 3 || minor != 0)
    throw Error(ErrorCode::kUnsupported, file.path(), fmt::format("byte {}", kNpyMagic.size()),
                fmt::format("version {}.{} of NumPy's format; 1.0, 2.0 and 3.0 are read", major, minor));
  std::array<std::byte, 4> length{};  // little-endian, whatever the order of the voxels
  const std::size_t length_bytes = major == 1 ? 2 : 4;
  file.readAt(start.size(), std::span(length).first(length_bytes));
  std::uint64_t bytes = 0;
  for (std::size_t i = length_bytes; i-- > 0;) bytes = bytes << 8 | std::to_integer<std::uint64_t>(length[i]);
  begin = start.size() + length_bytes;
  if (bytes > kMostNpyBytes)
    throw Error(ErrorCode::kFormat, file.path(), fmt::format("byte {}", start.size()),
                fmt::format("the header has {} bytes; the header of a volume has at most {}", bytes, kMostNpyBytes));
  std::string text(bytes, '\0');
  file.readAt(begin, std::as_writable_bytes(std::span(text)));
  return text;
}

}  // namespace

NpyHeader readNpyHeader(const File& file) {
  NpyHeader header;
  std::uint64_t begin = 0;
  const std::string text = readText(file, begin);
  header.end_offset = begin + text.size();
  NpyDictionary dictionary(file, begin, text);
  std::optional<std::string_view> descr;
  std::optional<bool> fortran_order;
  std::optional<std::vector<std::int64_t>> shape;
  const auto take = [&](auto& value, std::string_view key, auto&& read) {
    if (value) dictionary.fail(fmt::format("'{}' is given twice", key));
    value = read();
  };
  dictionary.expect('{');
  while (!dictionary.accept('}')) {
    const std::string_view key = dictionary.string();
    dictionary.expect(':');
    if (key == "descr") {
      if (dictionary.accept('[') || dictionary.accept('('))
        throw Error(ErrorCode::kUnsupported, file.path(), "descr",
                    "records of several fields, not one number a voxel; save one field as an array");
      take(descr, key, [&] { return dictionary.string(); });
    } else if (key == "fortran_order") {
      take(fortran_order, key, [&] { return dictionary.truth(); });
    } else if (key == "shape") {
      take(shape, key, [&] { return dictionary.tuple(); });
    } else {
      dictionary.fail(inQuotes(key) + " is not a key of NumPy's header; descr, fortran_order and shape are");
    }
    if (dictionary.accept(',')) continue;
    dictionary.expect('}');
    break;
  }
  dictionary.expectEnd();
  if (!descr || !fortran_order || !shape)
    dictionary.fail(fmt::format("'{}' is missing in the header", !descr           ? "descr"
                                                                 : !fortran_order ? "fortran_order"
                                                                                  : "shape"));
  takeType(file, *descr, header);
  header.fortran_order = *fortran_order;
  header.shape = std::move(*shape);
  return header;
}

}  // namespace kiln
