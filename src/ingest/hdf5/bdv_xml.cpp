#include "ingest/hdf5/bdv_xml.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/file/file.h"
#include "base/file/path_status.h"
#include "base/text.h"
#include "ingest/source/header_text.h"
#include "ingest/source/xml_reader.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kMostXmlBytes = 64 << 20;
constexpr std::size_t kMostTextBytes = 1 << 16;

/// Texts are taken at the end of an element.
class BdvReader : public XmlReader {
 public:
  using XmlReader::XmlReader;

  BdvDescription read() {
    parse();
    return std::move(out_);
  }

 private:
  void begin(std::string_view, const XmlAttributes& attributes) override {
    text_.clear();
    if (isAt("ViewSetup")) setup_ = {};
    if (!isAt("ViewRegistration")) return;
    view_ = {numberOfAttribute(attributes, "timepoint"), numberOfAttribute(attributes, "setup")};
    out_.affines[view_] = glm::dmat4(1.0);
  }

  void end() override {
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
    text_.clear();
  }

  void text(std::string_view more) override {
    if (text_.size() < kMostTextBytes) text_ += more;
  }

  bool isAt(std::string_view name, std::string_view parent = "") const {
    const std::size_t n = open().size();
    return n > 0 && open()[n - 1] == name && (parent.empty() || (n > 1 && open()[n - 2] == parent));
  }

  std::int64_t wholeOf(std::string_view text) const {
    const std::optional<std::int64_t> number = numberOf<std::int64_t>(text);
    if (!number) fail(fmt::format("{} must hold a whole number (found {})", open().back(), inQuotes(text)));
    return *number;
  }

  std::int64_t numberOfAttribute(const XmlAttributes& attributes, std::string_view key) const {
    if (const std::optional<std::string> value = attributes.find(key)) return wholeOf(*value);
    fail(fmt::format("{} has no {}", open().back(), inQuotes(key)));
  }

  std::vector<double> numbersOf(std::string text, std::size_t count) const {
    std::replace(text.begin(), text.end(), '\n', ' ');
    std::vector<double> out;
    for (const std::string& word : words(text))
      if (const std::optional<double> number = doubleOf(word)) out.push_back(*number);
    if (out.size() != count || words(text).size() != count)
      fail(fmt::format("{} must hold {} numbers (found {})", open().back(), count, inQuotes(text)));
    return out;
  }

  // The first transformation of the list is applied last. Rows of three by four.
  void addAffine(const std::vector<double>& rows) {
    glm::dmat4 affine(1.0);
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column) affine[column][row] = rows[static_cast<std::size_t>(4 * row + column)];
    out_.affines[view_] = out_.affines[view_] * affine;
  }

  BdvDescription out_;
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
  const File file(xml);
  if (file.size() > kMostXmlBytes)
    throw Error(ErrorCode::kFormat, xml, "",
                fmt::format("has {} bytes, more than the {} that are read", file.size(), kMostXmlBytes));
  return BdvReader(file).read();
}

BdvXmlBeside::BdvXmlBeside(const fs::path& image) : path_(fs::path(image).replace_extension(".xml")) {}

const std::optional<BdvDescription>& BdvXmlBeside::description() {
  if (!is_read_) description_ = readBdvXml(path_);
  is_read_ = true;
  return description_;
}

fs::path imageOfBdv(const fs::path& xml) {
  const fs::path image = fs::path(xml).replace_extension(".h5");
  if (isThere(image)) return image;
  throw Error(ErrorCode::kNotFound, xml, "",
              "the image of this BigDataViewer description, " + inQuotes(image.filename().string()) +
                  ", is missing; put it beside this file, or give an image of another name or format itself");
}

}  // namespace kiln
