#include "ingest/hdf5/bdv_xml.h"

#include <expat.h>
#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <memory>
#include <new>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/file/file.h"
#include "base/file/path_status.h"
#include "base/text.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kMostXmlBytes = 64 << 20;
constexpr std::size_t kMostXmlDepth = 64, kMostTextBytes = 1 << 16;

/// Follows the elements of the file; texts are taken at the end of an element. No exception may pass through Expat's
/// frames, so an exception is kept and thrown behind them.
class BdvReader {
 public:
  explicit BdvReader(const fs::path& xml) : xml_(xml), parser_(XML_ParserCreate(nullptr), &XML_ParserFree) {
    if (!parser_) throw std::bad_alloc();
    XML_SetUserData(parser_.get(), this);
    XML_SetElementHandler(
        parser_.get(),
        [](void* self, const char* name, const char** attributes) {
          of(self).guarded([&] { of(self).begin(name, attributes); });
        },
        [](void* self, const char*) { of(self).guarded([&] { of(self).end(); }); });
    XML_SetCharacterDataHandler(parser_.get(), [](void* self, const char* text, int length) {
      of(self).guarded([&] { of(self).addText({text, static_cast<std::size_t>(length)}); });
    });
    XML_SetStartDoctypeDeclHandler(parser_.get(), [](void* self, const char*, const char*, const char*, int) {
      of(self).guarded([&] { of(self).fail("has a document type, which BigDataViewer does not write"); });
    });
  }

  BdvDescription read(const std::string& text) {
    const XML_Status status = XML_Parse(parser_.get(), text.data(), static_cast<int>(text.size()), 1);
    if (thrown_) std::rethrow_exception(thrown_);
    if (status != XML_STATUS_OK)
      fail(std::string("is no XML (") + XML_ErrorString(XML_GetErrorCode(parser_.get())) + ")");
    return std::move(out_);
  }

 private:
  static BdvReader& of(void* self) { return *static_cast<BdvReader*>(self); }

  template <class Handle>
  void guarded(Handle handle) {
    if (thrown_) return;
    try {
      handle();
    } catch (...) {
      thrown_ = std::current_exception();
      XML_StopParser(parser_.get(), XML_FALSE);
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorCode::kFormat, xml_, fmt::format("line {}", XML_GetCurrentLineNumber(parser_.get())), what);
  }

  void begin(const char* name, const char** attributes) {
    if (path_.size() == kMostXmlDepth) fail(fmt::format("elements lie more than {} deep", kMostXmlDepth));
    path_.emplace_back(name);
    text_.clear();
    if (isAt("ViewSetup")) setup_ = {};
    if (!isAt("ViewRegistration")) return;
    view_ = {numberOfAttribute(attributes, "timepoint"), numberOfAttribute(attributes, "setup")};
    out_.affines[view_] = glm::dmat4(1.0);
  }

  void end() {
    const std::string text = trimmed(text_);
    if (isAt("id", "ViewSetup")) id_ = wholeOf(text);
    if (isAt("name", "ViewSetup")) setup_.name = text;
    if (isAt("unit", "voxelSize")) setup_.unit = text;
    if (isAt("size", "voxelSize")) {
      const std::vector<double> size = numbersOf(text, 3);
      setup_.voxel_size = glm::dvec3(size[0], size[1], size[2]);
    }
    if (isAt("ViewSetup")) out_.setups[id_] = setup_;
    if (isAt("affine", "ViewTransform")) addAffine(numbersOf(text, 12));
    path_.pop_back();
    text_.clear();
  }

  void addText(std::string_view text) {
    if (text_.size() < kMostTextBytes) text_ += text;
  }

  bool isAt(std::string_view name, std::string_view parent = "") const {
    const std::size_t n = path_.size();
    return n > 0 && path_[n - 1] == name && (parent.empty() || (n > 1 && path_[n - 2] == parent));
  }

  std::int64_t wholeOf(std::string_view text) const {
    const std::optional<std::int64_t> number = numberOf<std::int64_t>(text);
    if (!number) fail(fmt::format("{} must hold a whole number (found {})", path_.back(), inQuotes(text)));
    return *number;
  }

  std::int64_t numberOfAttribute(const char** attributes, std::string_view key) const {
    for (const char** a = attributes; a[0] != nullptr; a += 2)
      if (key == a[0]) return wholeOf(a[1]);
    fail(fmt::format("{} has no {}", path_.back(), inQuotes(key)));
  }

  std::vector<double> numbersOf(std::string text, std::size_t count) const {
    std::replace(text.begin(), text.end(), '\n', ' ');
    std::vector<double> out;
    for (const std::string& word : words(text))
      if (const std::optional<double> number = doubleOf(word)) out.push_back(*number);
    if (out.size() != count || words(text).size() != count)
      fail(fmt::format("{} must hold {} numbers (found {})", path_.back(), count, inQuotes(text)));
    return out;
  }

  // The first transformation of the list is applied last. Rows of three by four.
  void addAffine(const std::vector<double>& rows) {
    glm::dmat4 affine(1.0);
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) affine[column][row] = rows[static_cast<std::size_t>(4 * row + column)];
    out_.affines[view_] = out_.affines[view_] * affine;
  }

  const fs::path& xml_;
  std::unique_ptr<std::remove_pointer_t<XML_Parser>, decltype(&XML_ParserFree)> parser_;
  std::exception_ptr thrown_;
  BdvDescription out_;
  std::vector<std::string> path_;
  std::string text_;
  BdvDescription::Setup setup_;
  std::int64_t id_ = -1;
  std::pair<std::int64_t, std::int64_t> view_;
};

}  // namespace

std::string BdvDescription::setupName(std::int64_t setup) const {
  const auto found = setups.find(setup);
  return found == setups.end() ? "" : found->second.name;
}

std::string BdvDescription::unit(std::int64_t setup) const {
  const auto found = setups.find(setup);
  return found == setups.end() || found->second.unit == "pixel" || found->second.unit == "pixels" ? ""
                                                                                                  : found->second.unit;
}

std::optional<glm::dmat4> BdvDescription::worldFromIndex(std::int64_t time, std::int64_t setup) const {
  if (const auto found = affines.find({time, setup}); found != affines.end()) return found->second;
  const auto found = setups.find(setup);
  if (found == setups.end() || !found->second.voxel_size) return std::nullopt;
  return axesAffine(*found->second.voxel_size, glm::dvec3(0));
}

std::optional<BdvDescription> readBdvXml(const fs::path& xml) {
  if (!isThere(xml)) return std::nullopt;
  return BdvReader(xml).read(readTextFile(xml, kMostXmlBytes));
}

}  // namespace kiln
