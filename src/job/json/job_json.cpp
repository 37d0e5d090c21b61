#include "job/json/job_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "base/error.h"
#include "base/nearest_word.h"
#include "job/json/json_place.h"
#include "scene/scene_limits.h"

namespace kiln {
namespace {

using nlohmann::json;

// Walks the text once and builds nothing. Finds the first place that is not JSON, and repeated keys, of which a parser
// would silently drop one.
class Checker : public nlohmann::json_sax<json> {
 public:
  std::string problem;
  std::size_t bytes_read = 0;

  bool null() override { return true; }
  bool boolean(bool) override { return true; }
  bool number_integer(number_integer_t) override { return true; }
  bool number_unsigned(number_unsigned_t) override { return true; }
  bool number_float(number_float_t, const string_t&) override { return true; }
  bool string(string_t&) override { return true; }
  bool binary(binary_t&) override { return true; }
  bool start_array(std::size_t) override { return start(); }
  bool end_array() override { return end(); }
  bool start_object(std::size_t) override { return start(); }
  bool end_object() override { return end(); }
  bool key(string_t& name) override {
    if (keys_.back().insert(name).second) return true;
    problem = "key '" + name + "' is given twice in one object";
    return false;
  }
  bool parse_error(std::size_t position, const std::string&, const json::exception& error) override {
    bytes_read = position;
    problem = readableJsonError(error.what());
    return false;
  }

 private:
  // Documents of jobs are not a tenth as deep; printing a value recurses once per level.
  static constexpr std::size_t kDeepest = 100;

  bool start() {
    keys_.emplace_back();
    if (keys_.size() <= kDeepest) return true;
    problem = "lists and objects are nested more than " + std::to_string(kDeepest) + " deep";
    return false;
  }
  bool end() {
    keys_.pop_back();
    return true;
  }
  std::vector<std::set<std::string>> keys_;  // one per open list and object
};

std::string lineAndColumn(std::string_view text, std::size_t bytes_read) {
  const std::string_view before = text.substr(0, bytes_read > 0 ? std::min(bytes_read - 1, text.size()) : 0);
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t newline = before.rfind('\n');
  const std::size_t column = newline == std::string_view::npos ? before.size() + 1 : before.size() - newline;
  return "line " + std::to_string(line) + ", column " + std::to_string(column);
}

std::string shownValue(const json& value) {
  constexpr std::size_t kLongest = 60;
  std::string shown = value.dump(-1, ' ', true);
  if (shown.size() > kLongest) shown = shown.substr(0, kLongest) + "…";
  return shown;
}

json checkedDocument(const std::string& text, const std::filesystem::path& path) {
  // The library takes a NUL for the end of the text.
  if (const std::size_t nul = text.find('\0'); nul != std::string::npos)
    throw Error(ErrorCode::kFormat, path, lineAndColumn(text, nul + 1), "JSON has no NUL byte; remove it");
  Checker checker;
  if (!json::sax_parse(text, &checker, json::input_format_t::json, true, true)) {
    const std::string place = checker.bytes_read > 0 ? lineAndColumn(text, checker.bytes_read) : "";
    throw Error(ErrorCode::kFormat, path, place, checker.problem);
  }
  return json::parse(text, nullptr, true, true);
}

// "a", "b" or "c", in quotes.
std::string listOf(std::span<const std::string_view> names) {
  std::string out;
  for (std::size_t i = 0; i < names.size(); ++i)
    out += (i == 0 ? "\"" : i + 1 < names.size() ? ", \"" : " or \"") + std::string(names[i]) + "\"";
  return out;
}

// The system reads a name up to its first NUL and would open another file.
bool hasNul(const json& text) { return text.get_ref<const std::string&>().find('\0') != std::string::npos; }

constexpr std::string_view kWithoutNul = " without a NUL character";

}  // namespace

std::string readableJsonError(std::string message) {
  // "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error …": the last part is for people.
  const std::size_t column = message.find(", column ");
  const std::size_t start = column == std::string::npos ? message.find("] ") : message.find(": ", column);
  if (start != std::string::npos) message.erase(0, start + 2);
  return message;
}

bool NumberRange::operator()(double value) const {
  return (above ? value > least : value >= least) && (below ? value < most : value <= most);
}

std::string NumberRange::text() const {
  // Limits of lengths keep computations finite.
  const bool low = least > -kLongest, high = most < kLongest;
  if (low && high && !above && !below) return fmt::format("{} to {}", least, most);
  std::string out;
  if (low) out += fmt::format("{} {}", above ? "above" : "at least", least);
  if (low && high) out += " and ";
  if (high) out += fmt::format("{} {}", below ? "below" : "at most", most);
  return out;
}

std::string expectedNumber(const NumberRange& range, std::string_view unit) {
  const std::string limits = range.text();
  const bool between = limits.find(" to ") != std::string::npos;
  return fmt::format("a number{}{}{}{}", unit.empty() ? "" : " of ", unit,
                     limits.empty() ? ""
                     : between      ? " from "
                                    : " ",
                     limits);
}

std::string expectedWhole(std::int64_t least, std::int64_t most, std::string_view unit) {
  return fmt::format("a whole number{}{} from {} to {}", unit.empty() ? "" : " of ", unit, least, most);
}

struct JobObject::Document {
  json root;
  std::string text;
  std::filesystem::path path;
  std::optional<FlagText> flag;  // if the document is the value of a flag
};

JobObject::JobObject(Shared document, const json& root, const json& value, std::string place)
    : document_(std::move(document)), root_(&root), value_(&value), place_(std::move(place)) {
  if (!value_->is_object()) complainAt(place_, "expected an object {…}, found " + shownValue(*value_));
}

JobObject JobObject::parse(const std::string& text, const std::filesystem::path& path) {
  const auto document = std::make_shared<const Document>(Document{checkedDocument(text, path), text, path, {}});
  return JobObject(document, document->root, document->root, "");
}

std::vector<JobObject> JobObject::parseSeveral(const std::string& text, const std::filesystem::path& path) {
  const auto document = std::make_shared<const Document>(Document{checkedDocument(text, path), text, path, {}});
  const json& root = document->root;
  if (!root.is_array()) return {JobObject(document, root, root, "")};
  std::vector<JobObject> out;
  for (std::size_t i = 0; i < root.size(); ++i)
    out.push_back(JobObject(document, root[i], root[i], fmt::format("[{}]", i)));
  return out;
}

JobObject JobObject::ofFlag(const json& value, const FlagText& flag) {
  const auto document = std::make_shared<const Document>(Document{value, {}, {}, flag});
  return JobObject(document, document->root, document->root, "");
}

const std::filesystem::path& JobObject::path() const { return document_->path; }

JobObject JobObject::inside(const json& value, std::string place) const {
  return JobObject(document_, *root_, value, std::move(place));
}

const json* JobObject::find(std::string_view key) const {
  const auto found = value_->find(std::string(key));
  return found == value_->end() ? nullptr : &*found;
}

std::string JobObject::placeOf(std::string_view key) const {
  return place_.empty() ? std::string(key) : place_ + "." + std::string(key);
}

void JobObject::complain(std::string_view key, const std::string& sentence) const {
  complainAt(placeOf(key), sentence);
}

void JobObject::complainAt(const std::string& place, const std::string& sentence) const {
  const std::optional<FlagText>& flag = document_->flag;
  if (flag) throw Error(ErrorCode::kUsage, flag->flag + ": " + sentence);
  const std::string line = "line " + std::to_string(lineOfPlace(document_->text, place));
  throw Error(ErrorCode::kUsage, document_->path, place.empty() ? line : line + ", " + place, sentence);
}

void JobObject::refuse(std::string_view key, std::string_view expected, std::string_view hint) const {
  const std::string end(hint);
  if (const std::optional<FlagText>& flag = document_->flag; flag)
    complain(key, "expected " + flag->expected + ", found " + flag->found + end);
  const json* value = find(key);
  complain(key, "expected " + std::string(expected) + ", found " + (value ? shownValue(*value) : "nothing") + end);
}

void JobObject::requireWithin(std::string_view key, ListLimit limit, const json& list) const {
  if (list.size() > limit.most)
    complain(key, "expected at most " + std::to_string(limit.most) + " " + std::string(limit.entries) + ", found " +
                      std::to_string(list.size()));
}

void JobObject::requireKnown(std::initializer_list<std::string_view> known) const {
  requireOneOf(std::span(known.begin(), known.size()));
}

void JobObject::requireOneOf(std::span<const std::string_view> known) const {
  for (const auto& [key, value] : value_->items()) {
    if (std::find(known.begin(), known.end(), key) != known.end()) continue;
    const std::string_view nearest = nearestWord(key, known);
    complain(key.substr(0, 60), "unknown key; did you mean '" + std::string(nearest) + "'?");
  }
}

bool JobObject::isText(std::string_view key) const {
  const json* value = find(key);
  return value && value->is_string();
}

bool JobObject::isObject(std::string_view key) const {
  const json* value = find(key);
  return value && value->is_object();
}

bool JobObject::isNumber(std::string_view key) const {
  const json* value = find(key);
  return value && value->is_number();
}

std::optional<double> JobObject::format() const {
  for (const json* owner : {value_, root_}) {
    const auto found = owner->find("kiln");
    if (found != owner->end() && found->is_number()) return found->get<double>();
  }
  return std::nullopt;
}

std::optional<double> JobObject::number(std::string_view key, std::string_view expected, bool (*legal)(double)) const {
  const json* value = find(key);
  if (!value) return std::nullopt;
  if (!value->is_number() || !legal(value->get<double>())) refuse(key, expected);
  return value->get<double>();
}

std::optional<double> JobObject::number(std::string_view key, const NumberRange& range, std::string_view unit) const {
  const json* value = find(key);
  if (!value) return std::nullopt;
  if (!value->is_number() || !range(value->get<double>())) refuse(key, expectedNumber(range, unit));
  return value->get<double>();
}

std::optional<std::int64_t> JobObject::integer(std::string_view key, std::int64_t least, std::int64_t most,
                                               std::string_view unit) const {
  const json* value = find(key);
  if (!value) return std::nullopt;
  const bool fits = value->is_number() && value->get<double>() >= static_cast<double>(least) &&
                    value->get<double>() <= static_cast<double>(most) &&
                    value->get<double>() == std::floor(value->get<double>());
  if (!fits) refuse(key, expectedWhole(least, most, unit));
  return static_cast<std::int64_t>(value->get<double>());
}

std::optional<std::string> JobObject::text(std::string_view key, std::string_view expected) const {
  const json* value = find(key);
  if (!value) return std::nullopt;
  if (!value->is_string() || (!document_->flag && value->get_ref<const std::string&>().empty())) refuse(key, expected);
  if (hasNul(*value)) refuse(key, std::string(expected) + std::string(kWithoutNul));
  return value->get<std::string>();
}

std::optional<std::size_t> JobObject::choice(std::string_view key, std::span<const std::string_view> names) const {
  const json* value = find(key);
  if (!value) return std::nullopt;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (value->is_string() && value->get_ref<const std::string&>() == names[i]) return i;
  const std::string hint = value->is_string() ? meantWordHint(value->get_ref<const std::string&>(), names) : "";
  refuse(key, listOf(names), hint);
}

std::optional<bool> JobObject::flag(std::string_view key) const {
  const json* value = find(key);
  if (!value) return std::nullopt;
  if (!value->is_boolean()) refuse(key, "true or false");
  return value->get<bool>();
}

std::optional<std::vector<std::size_t>> JobObject::choices(std::string_view key,
                                                           std::span<const std::string_view> names) const {
  const json* value = find(key);
  if (!value) return std::nullopt;
  if (!value->is_array()) refuse(key, "a list of " + listOf(names));
  std::vector<std::size_t> out;
  for (const json& item : *value) {
    const auto found = std::find_if(names.begin(), names.end(), [&](std::string_view name) {
      return item.is_string() && item.get_ref<const std::string&>() == name;
    });
    const auto place = static_cast<std::size_t>(found - names.begin());
    const bool again = std::find(out.begin(), out.end(), place) != out.end();
    if (found == names.end() || (again && !document_->flag))
      refuse(key, "a list of " + listOf(names) + ", none of them twice");
    if (!again) out.push_back(place);
  }
  return out;
}

std::optional<std::vector<std::string>> JobObject::texts(std::string_view key, std::string_view expected) const {
  const json* value = find(key);
  if (!value) return std::nullopt;
  if (!value->is_array()) refuse(key, expected);
  std::vector<std::string> out;
  for (const json& item : *value) {
    if (!item.is_string()) refuse(key, expected);
    if (hasNul(item)) refuse(key, std::string(expected) + std::string(kWithoutNul));
    out.push_back(item.get<std::string>());
  }
  return out;
}

std::optional<std::vector<double>> JobObject::numberList(std::string_view key, std::string_view expected,
                                                         bool (*legal)(double)) const {
  const json* value = find(key);
  if (!value) return std::nullopt;
  if (!value->is_array()) refuse(key, expected);
  std::vector<double> out(value->size());
  fill(key, expected, legal, out);
  return out;
}

std::optional<std::vector<std::array<double, 2>>> JobObject::pairs(std::string_view key, std::string_view expected,
                                                                   bool (*legal)(double)) const {
  const json* value = find(key);
  if (!value) return std::nullopt;
  if (!value->is_array()) refuse(key, expected);
  std::vector<std::array<double, 2>> out;
  for (const json& item : *value) {
    if (!item.is_array() || item.size() != 2) refuse(key, expected);
    for (const json& number : item)
      if (!number.is_number() || !legal(number.get<double>())) refuse(key, expected);
    out.push_back({item[0].get<double>(), item[1].get<double>()});
  }
  return out;
}

std::optional<std::vector<std::array<double, 16>>> JobObject::matrices(std::string_view key, std::string_view expected,
                                                                       ListLimit limit, bool (*legal)(double)) const {
  const json* value = find(key);
  if (!value) return std::nullopt;
  const auto require = [&](bool right) {
    if (!right) refuse(key, expected);
  };
  require(value->is_array());
  requireWithin(key, limit, *value);
  std::vector<std::array<double, 16>> out;
  for (const json& matrix : *value) {
    require(matrix.is_array() && matrix.size() == 4);
    std::size_t place = 0;
    out.emplace_back();
    for (const json& row : matrix) {
      require(row.is_array() && row.size() == 4);
      for (const json& number : row) {
        require(number.is_number() && legal(number.get<double>()));
        out.back()[place++] = number.get<double>();
      }
    }
  }
  return out;
}

std::optional<JobObject> JobObject::object(std::string_view key) const {
  const json* value = find(key);
  if (!value) return std::nullopt;
  return inside(*value, placeOf(key));
}

std::optional<std::vector<JobObject>> JobObject::objects(std::string_view key, std::string_view expected,
                                                         ListLimit limit) const {
  const json* value = find(key);
  if (!value) return std::nullopt;
  if (!value->is_array()) refuse(key, expected);
  requireWithin(key, limit, *value);
  std::vector<JobObject> out;
  for (std::size_t i = 0; i < value->size(); ++i) {
    out.push_back(inside((*value)[i], placeOf(key) + fmt::format("[{}]", i)));
  }
  return out;
}

bool JobObject::fill(std::string_view key, std::string_view expected, const Legal& legal, std::span<double> out) const {
  const json* value = find(key);
  if (!value) return false;
  if (!value->is_array() || value->size() != out.size()) refuse(key, expected);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const json& item = (*value)[i];
    if (!item.is_number() || !legal(item.get<double>())) refuse(key, expected);
    out[i] = item.get<double>();
  }
  return true;
}

namespace legal {
bool length(double v) { return std::abs(v) <= kLongest; }
bool fraction(double v) { return v >= 0 && v <= 1; }
bool voxelValue(double v) { return std::abs(v) <= kLargestValue; }
}  // namespace legal

}  // namespace kiln
