// XML headers, parsed in steps. Hostile XML is bounded: no document type, so no entities; few nested elements; short
// tags.
#pragma once

#include <cstdint>
#include <exception>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/file/file.h"

namespace kiln {

/// The attributes of one element.
class XmlAttributes {
 public:
  /// shape: names and values by turns, with a null at the end.
  explicit XmlAttributes(const char** pairs) : pairs_(pairs) {}
  std::optional<std::string> find(std::string_view name) const;
  std::string get(std::string_view name, const char* otherwise = "") const { return find(name).value_or(otherwise); }

 private:
  const char** pairs_;
};

/// A derived class follows the elements of a file.
class XmlReader {
 public:
  explicit XmlReader(const File& file) : file_(file) {}
  virtual ~XmlReader() = default;
  XmlReader(const XmlReader&) = delete;
  XmlReader& operator=(const XmlReader&) = delete;

  /// Reads the file until its end, or until `stop`. throws: Error kFormat if the file is no XML, kIo; exceptions of the
  /// handlers.
  void parse();

 protected:
  /// Called behind the first tag of an element, which is then the last of `open`, and in front of the last tag.
  virtual void begin(std::string_view name, const XmlAttributes& attributes) = 0;
  virtual void end() {}
  virtual void text(std::string_view) {}

  const File& file() const { return file_; }
  /// Names of the elements that have begun and not ended.
  const std::vector<std::string>& open() const { return open_; }
  /// Ends `parse` after this handler.
  void stop() { stopped_ = true; }
  /// Begin of the bytes behind the tag of this handler. unit: bytes into the file.
  std::uint64_t afterTag() const { return after_tag_; }
  /// Throws an Error that names the line.
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFormat) const;

 private:
  class Expat;

  const File& file_;
  std::vector<std::string> open_;
  std::exception_ptr thrown_;
  std::uint64_t line_ = 1, after_tag_ = 0;
  bool stopped_ = false;
};

}  // namespace kiln
