#include "job/option_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "base/error.h"
#include "base/memory/memory.h"
#include "base/text.h"
#include "image/named_color.h"
#include "ingest/source/formats.h"
#include "job/job_names.h"

namespace kiln {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;

constexpr double kFarthestVoxel = 1e15;

template <class T>
json decimalOfText(std::string_view text) {
  const std::optional<T> value = decimalOf<T>(text);
  return value ? json(*value) : json();
}

json numberOfText(const std::string& text) { return decimalOfText<double>(text); }

json wholeOfText(const std::string& text) { return decimalOfText<std::int64_t>(text); }

// "auto" or a whole number.
json autoOfText(const std::string& text) { return text == "auto" ? json(text) : wholeOfText(text); }

json textOfText(const std::string& text) { return text; }

std::string valueNameOf(std::string_view unit, std::string_view otherwise) {
  std::string out(unit.empty() ? otherwise : unit.substr(unit.rfind(' ') + 1));
  for (char& c : out) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  return out;
}

std::vector<std::string> stringsOf(std::span<const std::string_view> names) { return {names.begin(), names.end()}; }

// throws: Error kUsage if the text names no colour.
glm::dvec3 namedColor(const JobObject& object, std::string_view key, const std::string& expected) {
  const auto color = colorNamed(*object.text(key, expected));
  if (!color) object.refuse(key, expected);
  return *color;
}

constexpr std::string_view kTransparent = "transparent";

// One end of a background, as a value of a job.
json backgroundOfText(const std::string& text) {
  if (text == kTransparent) return text;
  json out = colorOfText(text);
  if (out.is_array()) out.push_back(1);
  return out;
}

using Rgba = std::array<double, 4>;

Rgba backgroundFrom(const JobObject& object, std::string_view key) {
  const std::string expected =
      fmt::format("[red, green, blue, alpha] from 0 to 1, premultiplied, transparent, or {}", kColorForms);
  if (!object.isText(key)) return *object.numbers<4>(key, expected, legal::fraction);
  if (*object.text(key, expected) == kTransparent) return {};
  const glm::dvec3 color = namedColor(object, key, expected);
  return {color.r, color.g, color.b, 1};
}

ordered_json arrayOf(const ordered_json& item, int count) {
  return {{"type", "array"}, {"items", item}, {"minItems", count}, {"maxItems", count}};
}

// The form of a list of numbers; its flag is "a,b,c".
OptionForm listForm(ordered_json schema, std::string_view value_name, std::string expected) {
  OptionForm out;
  out.schema = std::move(schema);
  out.value_name = value_name;
  out.expected = std::move(expected);
  out.parse = [](const std::string& text) { return numbersOfText(text); };
  return out;
}

void readAuto(const JobObject& object, std::string_view key) {
  constexpr std::array<std::string_view, 1> kAuto = {"auto"};
  object.choice(key, kAuto);
}

}  // namespace

json numbersOfText(std::string_view text, char separator) {
  json out = json::array();
  for (const std::string_view part : splitAt(text, separator)) {
    const json number = decimalOfText<double>(part);
    if (number.is_null()) return {};
    out.push_back(number);
  }
  return out;
}

json colorOfText(std::string_view text) {
  if (colorNamed(text)) return text;
  json numbers = numbersOfText(text);
  return numbers.size() == 3 ? numbers : json();
}

std::string refusalOfText(const OptionForm& form, const std::string& text) {
  if (!form.parse(text).is_null()) return "";
  return fmt::format("expected {}, found {}", form.expected, quotedWrongText(form, {text}));
}

std::string quotedWrongText(const OptionForm& form, const std::vector<std::string>& texts) {
  for (const std::string& text : texts) {
    const std::string part = form.wrong_part ? form.wrong_part(text) : "";
    if (!part.empty() && part != text) return fmt::format("'{}' in '{}'", part, text);
  }
  return fmt::format("'{}'", fmt::join(texts, " "));
}

json valueOfText(const OptionForm& form, const std::string& text, std::string_view flag) {
  if (const std::string refusal = refusalOfText(form, text); !refusal.empty())
    throw Error(ErrorCode::kUsage, fmt::format("{}: {}", flag, refusal));
  return form.parse(text);
}

OptionForm Number::form() const {
  OptionForm out;
  if (ref.empty())
    out.schema = {{"type", "number"},
                  {range.above ? "exclusiveMinimum" : "minimum", range.least},
                  {range.below ? "exclusiveMaximum" : "maximum", range.most}};
  else
    out.schema = {{"$ref", ref}};
  out.value_name = valueNameOf(unit, "NUMBER");
  out.expected = expectedNumber(range, unit);
  out.limits = range.text();
  out.number = true;
  out.parse = numberOfText;
  return out;
}

OptionForm Whole::form() const {
  OptionForm out;
  out.schema = {{"type", "integer"}, {"minimum", least}, {"maximum", most}};
  out.value_name = valueNameOf(unit, "N");
  out.expected = expectedWhole(least, most, unit);
  out.limits = fmt::format("{} to {}", least, most);
  out.number = true;
  out.parse = wholeOfText;
  return out;
}

OptionForm WholeChoice::form() const {
  OptionForm out;
  out.schema["enum"] = ordered_json::array();
  if (or_auto) out.words.push_back("auto");
  for (const int number : numbers) out.words.push_back(fmt::format("{}", number));
  if (or_auto) out.schema["enum"].push_back("auto");
  for (const int number : numbers) out.schema["enum"].push_back(number);
  for (std::size_t i = 0; i < out.words.size(); ++i)
    out.expected += (i == 0 ? "" : i + 1 < out.words.size() ? ", " : " or ") + out.words[i];
  out.value_name = fmt::format("{}", fmt::join(out.words, "|"));
  out.number = !or_auto;
  out.parse = or_auto ? autoOfText : wholeOfText;
  return out;
}

void WholeChoice::read(const JobObject& object, std::string_view key, int& out) const {
  std::optional<int> number;
  read(object, key, number);
  out = *number;
}

void WholeChoice::read(const JobObject& object, std::string_view key, std::optional<int>& out) const {
  out.reset();
  if (or_auto && object.isText(key)) return readAuto(object, key);
  const auto [least, most] = std::minmax_element(numbers.begin(), numbers.end());
  const std::int64_t number = *object.integer(key, *least, *most);
  if (std::find(numbers.begin(), numbers.end(), number) == numbers.end()) object.refuse(key, form().expected);
  out = static_cast<int>(number);
}

ordered_json WholeChoice::write(const std::optional<int>& value) const {
  return value ? ordered_json(*value) : ordered_json("auto");
}

OptionForm Word::form() const {
  OptionForm out;
  out.schema = {{"enum", names}};
  out.value_name = fmt::format("{}", fmt::join(names, "|"));
  out.expected = fmt::format("one of {}", fmt::join(names, ", "));
  out.words = stringsOf(names);
  out.parse = textOfText;
  return out;
}

OptionForm WordOfFlag::form() const {
  OptionForm out = kind.form();
  out.arguments = JobFlag::Arguments::kNone;
  out.present = word;
  out.words.clear();
  return out;
}

OptionForm Switch::form() const {
  OptionForm out;
  out.schema = {{"type", "boolean"}};
  if (!on_off) {
    out.arguments = JobFlag::Arguments::kNone;
    return out;
  }
  out.value_name = "on|off";
  out.expected = "one of off, on";
  out.words = {"off", "on"};
  out.parse = [](const std::string& text) { return text == "on" || text == "off" ? json(text == "on") : json(); };
  return out;
}

void Switch::read(const JobObject& object, std::string_view key, bool& out) const { out = *object.flag(key); }

OptionForm AovList::form() const {
  OptionForm out;
  out.schema = {{"type", "array"}, {"items", {{"enum", kAovNames}}}, {"uniqueItems", true}};
  out.arguments = JobFlag::Arguments::kList;
  out.value_name = "NAME,...";
  out.expected = fmt::format("one of {}", fmt::join(kAovNames, ", "));
  out.words = stringsOf(kAovNames);
  out.parse = [](const std::string& text) {
    const bool known = std::find(kAovNames.begin(), kAovNames.end(), text) != kAovNames.end();
    return known ? json::array({text}) : json();
  };
  return out;
}

void AovList::read(const JobObject& object, std::string_view key, Aovs& out) const {
  out = {};
  const std::vector<std::size_t> places = *object.choices(key, kAovNames);
  for (const std::size_t place : places) out.of(static_cast<Aov>(place)) = true;
}

ordered_json AovList::write(const Aovs& aovs) const {
  ordered_json out;
  const bool is_there[] = {aovs.depth, aovs.normal, aovs.value};
  for (std::size_t i = 0; i < kAovNames.size(); ++i) {
    if (is_there[i]) out.push_back(kAovNames[i]);
  }
  return out;
}

OptionForm Text::form() const {
  OptionForm out;
  out.schema = {{"$ref", "text"}};
  out.value_name = value_name;
  out.expected = what;
  out.may_be_empty = true;
  out.parse = textOfText;
  return out;
}

void Text::read(const JobObject& object, std::string_view key, std::string& out) const {
  out = *object.text(key, what);
}

OptionForm FileName::form() const {
  OptionForm out = Text{"a file name", "FILE"}.form();
  out.may_be_empty = false;
  return out;
}

void FileName::read(const JobObject& object, std::string_view key, std::filesystem::path& out) const {
  out = *object.text(key, "a file name");
  if (!namesPhantom(out)) out = object.path().parent_path() / out;
}

OptionForm Bytes::form() const {
  OptionForm out;
  out.schema = {
      {"anyOf",
       {{{"type", "string"}, {"pattern", "^([0-9]+[.]?[0-9]*|[.][0-9]+)([eE][-+]?[0-9]+)?[KMGTkmgt]?([iI]?[bB])?$"}},
        Whole{1, std::int64_t{1} << 52}.form().schema}}};
  out.value_name = "BYTES";
  out.expected = "an amount of memory such as 512M or 2G";
  out.parse = textOfText;
  return out;
}

void Bytes::read(const JobObject& object, std::string_view key, std::uint64_t& out) const {
  if (!object.isText(key)) {
    out = static_cast<std::uint64_t>(*object.integer(key, 1, std::int64_t{1} << 52));
    return;
  }
  constexpr std::string_view kExpected = "an amount of memory such as \"512M\" or \"2G\"";
  try {
    out = parseBytes(*object.text(key, kExpected));
  } catch (const Error&) {
    object.refuse(key, kExpected);
  }
}

ordered_json Bytes::write(std::uint64_t bytes) const {
  const std::uint64_t gib = bytes >> 30;
  return gib << 30 == bytes ? fmt::format("{}G", gib) : roundedUpBytes(bytes);
}

OptionForm Rate::form() const {
  OptionForm out;
  out.schema = {
      {"type", {"number", "string"}}, {"minimum", 0.1}, {"maximum", 1000}, {"pattern", "^[0-9]+([.][0-9]+|/[0-9]+)?$"}};
  out.value_name = "FPS";
  out.expected = kFrameRateForms;
  out.parse = textOfText;
  return out;
}

void Rate::read(const JobObject& object, std::string_view key, FrameRate& out) const {
  const std::string text =
      object.isText(key) ? *object.text(key, kFrameRateForms)
                         : fmt::format("{}", *object.number(key, kFrameRateForms, [](double v) { return v > 0; }));
  const std::optional<FrameRate> rate = frameRateFrom(text);
  if (!rate) object.refuse(key, kFrameRateForms);
  out = *rate;
}

OptionForm WorldVector::form() const {
  return listForm({{"$ref", "vector"}}, "X,Y,Z",
                  direction ? "three finite numbers X,Y,Z, not all zero" : "three finite numbers X,Y,Z");
}

glm::dvec3 WorldVector::readVector(const JobObject& object, std::string_view key) const {
  const auto v = *object.numbers<3>(key, "[x, y, z] in world units", legal::length);
  const glm::dvec3 out(v[0], v[1], v[2]);
  if (direction && !(glm::length(out) > 0)) object.refuse(key, "a direction, which the zero vector is not");
  return out;
}

OptionForm PictureShift::form() const {
  return listForm({{"$ref", "pair"}}, "X,Y", "two numbers X,Y from -100 to 100");
}

void PictureShift::read(const JobObject& object, std::string_view key, std::optional<glm::dvec2>& out) const {
  constexpr NumberRange kRange{-100, 100};
  const auto shift = *object.numbers<2>(key, "[x, y] from -100 to 100 widths and heights of the picture", kRange);
  out = glm::dvec2(shift[0], shift[1]);
}

ordered_json PictureShift::write(const std::optional<glm::dvec2>& shift) const {
  return shift ? ordered_json{shift->x, shift->y} : ordered_json();
}

OptionForm ColorValue::form() const {
  OptionForm out;
  out.schema["anyOf"] = {{{"$ref", "colorName"}}, arrayOf({{"$ref", ref}}, 3)};
  out.value_name = "COLOR";
  out.expected = fmt::format("R,G,B from {}, or {}", range.text(), kColorForms);
  out.words = stringsOf(colorNames());
  out.parse = [](const std::string& text) { return colorOfText(text); };
  return out;
}

glm::dvec3 ColorValue::readColor(const JobObject& object, std::string_view key) const {
  const std::string expected = fmt::format("[red, green, blue] from {}, or {}", range.text(), kColorForms);
  if (object.isText(key)) return namedColor(object, key, expected);
  const auto c = *object.numbers<3>(key, expected, range);
  return {c[0], c[1], c[2]};
}

OptionForm BackgroundColors::form() const {
  OptionForm out;
  out.schema = {{"anyOf", {{{"$ref", "backgroundColor"}}, {{"$ref", "gradient"}}}}};
  out.value_name = "COLOR[:COLOR]";
  out.expected = fmt::format("COLOR or COLOR:COLOR (top:bottom), each transparent, R,G,B from 0 to 1, {}", kColorForms);
  out.words = stringsOf(colorNames());
  out.words.insert(out.words.begin(), std::string(kTransparent));
  out.parse = [](const std::string& text) -> json {
    const std::size_t colon = std::min(text.find(':'), text.size());
    const json top = backgroundOfText(text.substr(0, colon));
    if (colon == text.size() || top.is_null()) return top;
    const json bottom = backgroundOfText(text.substr(colon + 1));
    return bottom.is_null() ? bottom : json{{"top", top}, {"bottom", bottom}};
  };
  out.wrong_part = [](const std::string& text) -> std::string {
    for (const std::string_view part : splitAt(text, ':')) {
      const json color = backgroundOfText(std::string(part));
      const auto legal = [](const json& number) { return !number.is_number() || legal::fraction(number); };
      if (color.is_null() || !std::ranges::all_of(color, legal)) return std::string(part);
    }
    return {};
  };
  return out;
}

void BackgroundColors::read(const JobObject& object, std::string_view key, std::optional<Background>& out) const {
  if (!object.isObject(key)) {
    const Rgba all = backgroundFrom(object, key);
    out = Background{all, all};
    return;
  }
  const JobObject ends = *object.object(key);
  ends.requireKnown({"top", "bottom"});
  for (const char* end : {"top", "bottom"}) {
    if (!ends.has(end)) ends.complain(end, "is missing; a gradient has top and bottom");
  }
  out = Background{backgroundFrom(ends, "top"), backgroundFrom(ends, "bottom")};
}

ordered_json BackgroundColors::write(const std::optional<Background>& background) const {
  if (!background) return {};
  if (background->top == background->bottom) return background->top;
  return {{"top", background->top}, {"bottom", background->bottom}};
}

OptionForm PixelBox::form() const {
  return listForm(arrayOf(Whole{0, kLargestSide_px}.form().schema, 4), "X,Y,W,H",
                  fmt::format("four whole numbers of pixels X,Y,W,H from 0 to {}", kLargestSide_px));
}

void PixelBox::read(const JobObject& object, std::string_view key, std::optional<PixelRect>& out) const {
  const auto legal = [](double v) { return v >= 0 && v <= kLargestSide_px && v == std::floor(v); };
  const auto c = *object.numbers<4>(key, "four whole numbers of pixels, [x, y, width, height]", legal);
  const auto at = [&](std::size_t i) { return static_cast<int>(c[i]); };
  out = PixelRect{at(0), at(1), at(0) + at(2), at(1) + at(3)};
}

ordered_json PixelBox::write(const std::optional<PixelRect>& rect) const {
  if (!rect) return {};
  return {rect->x0, rect->y0, rect->width(), rect->height()};
}

OptionForm VoxelBounds::form() const {
  return listForm(arrayOf({{"type", "integer"}, {"minimum", -kFarthestVoxel}, {"maximum", kFarthestVoxel}}, 6),
                  "X0,Y0,Z0,X1,Y1,Z1", "six whole numbers X0,Y0,Z0,X1,Y1,Z1, each X0 below its X1 (half-open)");
}

void VoxelBounds::read(const JobObject& object, std::string_view key, std::optional<VoxelBox>& out) const {
  constexpr std::string_view kExpected =
      "six whole numbers [x0, y0, z0, x1, y1, z1] of voxels, each x0 below its x1 (half-open)";
  const auto voxel = [](double v) { return std::abs(v) <= kFarthestVoxel && v == std::floor(v); };
  const auto n = *object.numbers<6>(key, kExpected, voxel);
  VoxelBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const double lo = n[static_cast<std::size_t>(axis)], hi = n[static_cast<std::size_t>(axis) + 3];
    if (!(lo < hi)) object.refuse(key, kExpected);
    box.lo[axis] = static_cast<std::int64_t>(lo);
    box.hi[axis] = static_cast<std::int64_t>(hi);
  }
  out = box;
}

ordered_json VoxelBounds::write(const std::optional<VoxelBox>& box) const {
  if (!box) return {};
  return {box->lo.x, box->lo.y, box->lo.z, box->hi.x, box->hi.y, box->hi.z};
}

OptionForm WorldBounds::form() const {
  return listForm(arrayOf({{"$ref", "length"}}, 6), "X0,Y0,Z0,X1,Y1,Z1",
                  "six numbers X0,Y0,Z0,X1,Y1,Z1 in world units, each X0 below its X1");
}

void WorldBounds::read(const JobObject& object, std::string_view key, Clipping& out) const {
  constexpr std::string_view kExpected = "[x0, y0, z0, x1, y1, z1] in world units, each x0 below its x1";
  const auto n = *object.numbers<6>(key, kExpected, legal::length);
  const glm::dvec3 lo(n[0], n[1], n[2]), hi(n[3], n[4], n[5]);
  if (!(lo.x < hi.x && lo.y < hi.y && lo.z < hi.z)) object.refuse(key, kExpected);
  const std::vector<ClipPlane> faces = facesOf(lo, hi);
  const auto begin = out.planes.begin();
  out.planes.erase(begin, begin + static_cast<std::ptrdiff_t>(out.box_faces));
  out.planes.insert(out.planes.begin(), faces.begin(), faces.end());
  out.box_faces = faces.size();
}

OptionForm ValueWindow::form() const {
  return listForm({{"$ref", "pair"}}, "CENTRE,WIDTH", "CENTRE,WIDTH, the width above 0");
}

void ValueWindow::read(const JobObject& object, std::string_view key, std::optional<Window>& out) const {
  constexpr std::string_view kExpected = "[centre, width] in the volume's values, the width above 0";
  const auto numbers = *object.numbers<2>(key, kExpected, legal::voxelValue);
  if (!(numbers[1] > 0)) object.refuse(key, kExpected);
  out = Window{numbers[0], numbers[1]};
}

ordered_json ValueWindow::write(const std::optional<Window>& window) const {
  if (!window) return {};
  return {window->centre, window->width};
}

}  // namespace kiln
