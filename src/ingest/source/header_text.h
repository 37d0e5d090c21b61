// Text headers of NRRD and MetaImage: lines with their numbers, fields that may be given once, and numbers read without
// a locale. Every failure names the line.
#pragma once

#include <array>
#include <string_view>

#include "base/error.h"
#include "base/file.h"
#include "ingest/source/volume_source.h"

namespace kiln {

/// The lines at the front of a file whose rest may be binary. Ends of line are LF or CRLF.
class HeaderLines {
 public:
  explicit HeaderLines(const File& file) : file_(file) {}
  /// The next line without its end, or empty where the file ends. throws: Error kFormat where a line or the header is
  /// too long to be text.
  std::optional<std::string> next();
  /// Of the line that `next` returned last; the first is 1.
  int number() const { return number_; }
  /// unit: bytes; just after that line.
  std::uint64_t endOffset() const { return offset_; }

 private:
  bool refill();

  const File& file_;
  std::string buffer_;
  std::size_t used_ = 0;
  std::uint64_t offset_ = 0;
  int number_ = 0;
};

/// One field of a header. `key` is the name that the format reader gives it, `written` the file's own spelling.
struct HeaderField {
  std::string key, written, value;
  int line = 0;
};

/// The fields of one header.
class HeaderFields {
 public:
  explicit HeaderFields(std::filesystem::path path) : path_(std::move(path)) {}
  /// throws: Error kFormat where a field of this key is there already; with `same_again`, only where another spelling
  /// of the field gave another value.
  void add(HeaderField field, bool same_again = false);
  /// Null where there is none.
  const HeaderField* find(std::string_view key) const;
  /// throws: Error kFormat where there is none.
  const HeaderField& require(std::string_view key) const;
  const std::filesystem::path& path() const { return path_; }

  /// Throws an Error of `code` at the field's line: "line 4: spacings: WHAT".
  [[noreturn]] void fail(const HeaderField& field, const std::string& what, ErrorCode code = ErrorCode::kFormat) const;
  [[noreturn]] void unsupported(const HeaderField& field, const std::string& what) const {
    fail(field, what, ErrorCode::kUnsupported);
  }
  /// The numbers of a field. throws: Error kFormat where it does not hold exactly `count` of them.
  std::vector<double> doubles(const HeaderField& field, std::size_t count) const;
  std::vector<std::int64_t> integers(const HeaderField& field, std::size_t count) const;
  Extent3 extent(const HeaderField& field) const;
  glm::dvec3 vector(const HeaderField& field) const;
  /// Takes the values of some axes out of a field that has `dropped.size()` values, one for each axis; where the header
  /// has no such field, nothing changes. shape: a value is a word, a text in quotation marks or a vector in
  /// parentheses. throws: Error kFormat where the field has another number of values.
  void dropAxes(std::string_view key, const std::vector<bool>& dropped);
  /// Gives a field another value. requires: a field of this key.
  void replace(std::string_view key, std::string value);
  /// The one file, beside this header, that the field names. throws: Error kNotFound naming both, kFormat for an empty
  /// name, for the header itself and for what is no regular file, kUnsupported for a list or a series.
  std::filesystem::path dataFile(const HeaderField& field) const;

 private:
  std::filesystem::path path_;
  std::vector<HeaderField> fields_;
};

std::string trimmed(std::string_view text);
std::vector<std::string> words(std::string_view text);
/// Words, texts in quotation marks and vectors in parentheses, each with its marks.
std::vector<std::string> axisValues(std::string_view text);
/// The whole of `text` as a number, or empty; "nan" and "inf" are numbers here.
std::optional<double> doubleOf(std::string_view text);
std::optional<std::int64_t> integerOf(std::string_view text);

/// `text` for an error message: printable and short.
std::string inQuotes(std::string_view text);

/// The affine with these edge lengths along the world's axes and voxel (0,0,0) at `origin`.
glm::dmat4 axesAffine(const glm::dvec3& spacing, const glm::dvec3& origin);
/// The affine whose axis a steps by `directions[a]`.
glm::dmat4 directionsAffine(const std::array<glm::dvec3, 3>& directions, const glm::dvec3& origin);

}  // namespace kiln
