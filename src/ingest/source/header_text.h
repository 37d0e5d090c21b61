// Text headers of NRRD and MetaImage: numbered lines, unique fields, and numbers read without a locale. Every error
// names the line.
#pragma once

#include <array>
#include <string_view>

#include "base/error.h"
#include "base/file/file.h"
#include "base/text.h"
#include "ingest/source/volume_source.h"

namespace kiln {

/// Reads the text lines at the front of a file whose rest may be binary. Line ends are LF or CRLF.
class HeaderLines {
 public:
  /// Begins at byte `offset` of the file.
  explicit HeaderLines(const File& file, std::uint64_t offset = 0) : file_(file), begin_(offset), offset_(offset) {}
  /// Returns the next line without its end, or empty at the end of the file. throws: Error kFormat if a line or the
  /// header is too long to be text.
  std::optional<std::string> next();
  /// Returns the lines up to the end of the file, trimmed, without empty ones. throws: as next.
  std::vector<std::string> rest();
  /// Number of the line last returned by `next`; the first line is 1.
  int number() const { return number_; }
  /// End of the line last returned by `next`. unit: bytes.
  std::uint64_t endOffset() const { return offset_; }

 private:
  bool refill();

  const File& file_;
  std::string buffer_;
  std::size_t used_ = 0;
  std::uint64_t begin_, offset_;
  int number_ = 0;
};

/// True if the value of a field of data files says that the following lines of the header are the names.
bool namesList(std::string_view value);

/// One field of a header. `key` is the format reader's name of the field, `written` the file's spelling.
struct HeaderField {
  std::string key, written, value;
  int line = 0;
};

/// The fields of one header.
class HeaderFields {
 public:
  explicit HeaderFields(std::filesystem::path path) : path_(std::move(path)) {}
  /// throws: Error kFormat if the key exists already; with `same_again`, only if another spelling of the field
  /// has another value.
  void add(HeaderField field, bool same_again = false);
  /// Null if the field is missing.
  const HeaderField* find(std::string_view key) const;
  /// throws: Error kFormat if the field is missing.
  const HeaderField& require(std::string_view key) const;
  const std::filesystem::path& path() const { return path_; }

  /// Throws an Error of `code` at the field's line: "line 4: spacings: WHAT".
  [[noreturn]] void fail(const HeaderField& field, const std::string& what, ErrorCode code = ErrorCode::kFormat) const;
  [[noreturn]] void unsupported(const HeaderField& field, const std::string& what) const {
    fail(field, what, ErrorCode::kUnsupported);
  }
  /// Parses the numbers of a field. throws: Error kFormat if the field does not hold exactly `count` numbers.
  std::vector<double> doubles(const HeaderField& field, std::size_t count) const;
  std::vector<std::int64_t> integers(const HeaderField& field, std::size_t count) const;
  Extent3 extent(const HeaderField& field) const;
  glm::dvec3 vector(const HeaderField& field) const;
  /// Removes the values of the dropped axes from a field with `dropped.size()` values, one per axis. A missing field is
  /// no error. shape: a value is a word, a text in quotation marks or a vector in parentheses.
  /// throws: Error kFormat if the field has another number of values.
  void dropAxes(std::string_view key, const std::vector<bool>& dropped);
  /// Replaces the value of a field. requires: the field exists.
  void replace(std::string_view key, std::string value);
  /// Returns the data files named by the field, relative to this header's folder: one name; "LIST", whose names are the
  /// lines `listed`; or a pattern with the first number, the last and the step, "s%03d.raw 0 61 1".
  /// throws: Error kNotFound naming header and file; kFormat for an empty name or list, a pattern other than %d, the
  /// header itself and anything but a regular file.
  std::vector<std::filesystem::path> dataFiles(const HeaderField& field, const std::vector<std::string>& listed) const;

 private:
  std::filesystem::path dataFile(const HeaderField& field, const std::string& name) const;
  std::vector<std::string> namesOf(const HeaderField& field, const std::vector<std::string>& listed) const;

  std::filesystem::path path_;
  std::vector<HeaderField> fields_;
};

/// As numberOf, with an optional plus in front.
template <class T>
std::optional<T> signedNumberOf(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  return numberOf<T>(text);
}

std::string trimmed(std::string_view text);
std::vector<std::string> words(std::string_view text);
/// Splits into words, texts in quotation marks and vectors in parentheses; the marks are kept.
std::vector<std::string> axisValues(std::string_view text);
/// Parses all of `text` as a number; empty if it is not a number. "nan" and "inf" are numbers.
std::optional<double> doubleOf(std::string_view text);
std::optional<std::int64_t> integerOf(std::string_view text);

/// Quotes `text` for an error message: printable and short.
std::string inQuotes(std::string_view text);

/// True if x is so short beside y and z that the axis may hold colours or vectors.
bool mayBeChannels(const Extent3& dims);

/// Throws an Error kUsage: `file` places its voxels itself, so --spacing does not apply.
[[noreturn]] void refuseSpacing(const std::filesystem::path& file);

/// Returns the affine with the given edge lengths along the world axes and voxel (0,0,0) at `origin`.
glm::dmat4 axesAffine(const glm::dvec3& spacing, const glm::dvec3& origin);
/// Returns the affine whose axis a steps by `directions[a]`.
glm::dmat4 directionsAffine(const std::array<glm::dvec3, 3>& directions, const glm::dvec3& origin);

}  // namespace kiln
