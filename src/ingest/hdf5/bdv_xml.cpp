#include "ingest/hdf5/bdv_xml.h"

#include <expat.h>
#include <fmt/format.h>

#include <memory>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/file.h"
#include "base/path_status.h"
#include "base/text.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kMostXmlBytes = 64 << 20;
constexpr std::size_t kMostXmlDepth = 64;

std::vector<double> numbersIn(const std::string& text) {
  std::vector<double> out;
  for (const std::string& word : words(text)) out.push_back(doubleOf(word).value_or(0));
  return out;
}

/// Follows the elements of the file; texts are taken at the end of an element.
class BdvReader {
 public:
  explicit BdvReader(BdvDescription& out) : out_(out) {}

  void begin(const char* name, const char** attributes) {
    if (path_.size() < kMostXmlDepth) path_.emplace_back(name);
    text_.clear();
    if (isAt("ViewSetup")) setup_ = {};
    if (isAt("ViewRegistration")) {
      const auto number = [&](std::string_view key) {
        for (const char** a = attributes; a[0] != nullptr; a += 2)
          if (key == a[0]) return numberOf<std::int64_t>(a[1]).value_or(-1);
        return std::int64_t{-1};
      };
      view_ = {number("timepoint"), number("setup")};
      out_.affines[view_] = glm::dmat4(1.0);
    }
  }

  void end() {
    const std::string text = trimmed(text_);
    if (isAt("id", "ViewSetup")) id_ = numberOf<std::int64_t>(text).value_or(-1);
    if (isAt("name", "ViewSetup")) setup_.name = text;
    if (isAt("unit", "voxelSize")) setup_.unit = text;
    if (isAt("size", "voxelSize"))
      if (const std::vector<double> size = numbersIn(text); size.size() == 3)
        setup_.voxel_size = glm::dvec3(size[0], size[1], size[2]);
    if (isAt("ViewSetup")) out_.setups[id_] = setup_;
    if (isAt("affine", "ViewTransform")) addAffine(numbersIn(text));
    if (!path_.empty()) path_.pop_back();
    text_.clear();
  }

  void addText(const char* text, int length) {
    if (text_.size() < (1 << 16)) text_.append(text, static_cast<std::size_t>(length));
  }

 private:
  bool isAt(std::string_view name, std::string_view parent = "") const {
    const std::size_t n = path_.size();
    return n > 0 && path_[n - 1] == name && (parent.empty() || (n > 1 && path_[n - 2] == parent));
  }
  // The first transformation of the list is applied last. Rows of three by four.
  void addAffine(const std::vector<double>& rows) {
    if (rows.size() != 12) return;
    glm::dmat4 affine(1.0);
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) affine[column][row] = rows[static_cast<std::size_t>(4 * row + column)];
    out_.affines[view_] = out_.affines[view_] * affine;
  }

  BdvDescription& out_;
  std::vector<std::string> path_;
  std::string text_;
  BdvDescription::Setup setup_;
  std::int64_t id_ = -1;
  std::pair<std::int64_t, std::int64_t> view_;
};

struct FreeParser {
  void operator()(XML_Parser parser) const { XML_ParserFree(parser); }
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
  const std::string text = readTextFile(xml, kMostXmlBytes);
  BdvDescription out;
  BdvReader reader(out);
  const std::unique_ptr<std::remove_pointer_t<XML_Parser>, FreeParser> parser(XML_ParserCreate(nullptr));
  if (!parser) throw std::bad_alloc();
  XML_SetUserData(parser.get(), &reader);
  XML_SetElementHandler(
      parser.get(), [](void* data, const char* name, const char** a) { static_cast<BdvReader*>(data)->begin(name, a); },
      [](void* data, const char*) { static_cast<BdvReader*>(data)->end(); });
  XML_SetCharacterDataHandler(parser.get(),
                              [](void* data, const char* s, int n) { static_cast<BdvReader*>(data)->addText(s, n); });
  if (XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), 1) == XML_STATUS_OK) return out;
  throw Error(ErrorCode::kFormat, xml, fmt::format("line {}", XML_GetCurrentLineNumber(parser.get())),
              std::string("is no XML (") + XML_ErrorString(XML_GetErrorCode(parser.get())) + ")");
}

}  // namespace kiln
