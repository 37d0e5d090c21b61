#include "ingest/source/json_node.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/file/file.h"
#include "base/memory/memory.h"
#include "base/text.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

using nlohmann::json;

constexpr std::uint64_t kMostBytes = 16 << 20;
// Deeper values would overflow the stack of recursive functions.
constexpr int kMostJsonDepth = 64;
constexpr std::uint64_t kMostValues = 1 << 18, kMostValueBytes = 100;

// Programs in Python write numbers that JSON lacks without quotes; they become texts.
std::string withQuotedNumbers(std::string text) {
  constexpr std::string_view kNumbers[] = {"NaN", "Infinity", "-Infinity"};
  if (text.find(kNumbers[0]) == std::string::npos && text.find(kNumbers[1]) == std::string::npos) return text;
  std::string out;
  bool in_text = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const std::string_view rest = std::string_view(text).substr(at);
    const auto number = std::find_if(std::begin(kNumbers), std::end(kNumbers),
                                     [&](std::string_view name) { return !in_text && rest.starts_with(name); });
    if (number != std::end(kNumbers)) {
      out.append("\"").append(*number).append("\"");
      at += number->size() - 1;
      continue;
    }
    if (rest[0] == '"') in_text = !in_text;
    out += rest[0];
    if (in_text && rest[0] == '\\' && rest.size() > 1) out += text[++at];
  }
  return out;
}

// Consolidated metadata repeat other headers, of which the files themselves are read.
std::shared_ptr<const json> documentOf(const fs::path& file, std::string as_written) {
  const std::string text = withQuotedNumbers(std::move(as_written));
  std::uint64_t values = 0;
  bool is_repeated = false;
  const auto keep = [&](int depth, json::parse_event_t event, json& value) {
    using Event = json::parse_event_t;
    if (depth > kMostJsonDepth)
      throw Error(ErrorCode::kFormat, file, "", fmt::format("values lie more than {} deep", kMostJsonDepth));
    if (event == Event::key && depth == 1) is_repeated = value == "consolidated_metadata";
    if (event == Event::key) return !is_repeated;
    const bool is_value = event == Event::value || event == Event::array_start || event == Event::object_start;
    if (is_value && !is_repeated && ++values > kMostValues)
      throw Error(ErrorCode::kFormat, file, "", fmt::format("has more than {} values", kMostValues));
    return true;
  };
  try {
    return std::make_shared<const json>(json::parse(text, keep));
  } catch (const json::parse_error& error) {
    throw Error(ErrorCode::kFormat, file, fmt::format("byte {}", error.byte), "is no JSON");
  } catch (const json::exception&) {
    throw Error(ErrorCode::kFormat, file, "", "has a number that no type of JSON holds");
  }
}

// "NaN", "Infinity" and "-Infinity" are the texts of Zarr for numbers that JSON lacks.
std::optional<double> numberIn(const std::string& text) {
  const std::string_view digits = std::string_view(text).substr(text.starts_with('+') ? 1 : 0);
  if (digits == "NaN") return std::numeric_limits<double>::quiet_NaN();
  if (digits == "Infinity") return std::numeric_limits<double>::infinity();
  if (digits == "-Infinity") return -std::numeric_limits<double>::infinity();
  return numberOf<double>(digits);
}

// In memory: the text, perhaps with quoted numbers, its parsed texts, and the values.
std::uint64_t headerBytes(std::uint64_t length, std::uint64_t values) {
  return 3 * length + std::min(values, kMostValues) * kMostValueBytes;
}

// A value has two characters or more.
std::string textWithin(std::uint64_t memory_bytes, const fs::path& file) {
  const std::uint64_t length = File(file).size();
  if (length <= kMostBytes) requireHeaderFits(file, headerBytes(length, length / 2), memory_bytes);
  return readTextFile(file, kMostBytes);
}

// Each value but the first follows one of these characters. Letters inside texts count, too.
std::string countedWithin(std::uint64_t memory_bytes, const fs::path& file, std::string text) {
  const auto values = std::count_if(text.begin(), text.end(), [](char c) { return c == ',' || c == '[' || c == '{'; });
  requireHeaderFits(file, headerBytes(text.size(), static_cast<std::uint64_t>(values) + 1), memory_bytes);
  return text;
}

}  // namespace

void requireHeaderFits(const fs::path& file, std::uint64_t needed_bytes, std::uint64_t memory_bytes) {
  if (needed_bytes > memory_bytes)
    throw Error(ErrorCode::kBudget, file, "--memory",
                fmt::format("the header takes up to {} in memory (allowed: {})", formatBytes(needed_bytes),
                            formatBytes(memory_bytes)));
}

JsonNode::JsonNode(const fs::path& file, std::uint64_t memory_bytes)
    : JsonNode(file, textWithin(memory_bytes, file), UINT64_MAX) {}

JsonNode::JsonNode(const fs::path& file, std::string text, std::uint64_t memory_bytes)
    : document_(documentOf(file, countedWithin(memory_bytes, file, std::move(text)))),
      value_(document_.get()),
      file_(file) {}

JsonNode::JsonNode(const JsonNode& parent, const json& value, std::string place)
    : document_(parent.document_), value_(&value), file_(parent.file_), place_(std::move(place)) {}

std::optional<JsonNode> JsonNode::find(const std::string& key) const {
  if (!value_->is_object()) fail("must be an object");
  const auto found = value_->find(key);
  if (found == value_->end() || found->is_null()) return std::nullopt;
  return JsonNode(*this, *found, place_.empty() ? key : place_ + "." + key);
}

std::optional<JsonNode> JsonNode::findIn(const std::string& key) const {
  return value_->is_object() ? find(key) : std::nullopt;
}

JsonNode JsonNode::at(const std::string& key) const {
  std::optional<JsonNode> found = find(key);
  if (!found) fail(fmt::format("{} is missing", inQuotes(key)));
  return *std::move(found);
}

std::vector<std::string> JsonNode::keys() const {
  if (!value_->is_object()) fail("must be an object");
  std::vector<std::string> out;
  for (const auto& item : value_->items()) out.push_back(item.key());
  return out;
}

std::vector<JsonNode> JsonNode::items(std::size_t most) const {
  if (!value_->is_array()) fail("must be a list");
  if (value_->size() > most) fail(fmt::format("must have at most {} items (found {})", most, value_->size()));
  std::vector<JsonNode> out;
  for (std::size_t i = 0; i < value_->size(); ++i)
    out.push_back(JsonNode(*this, (*value_)[i], fmt::format("{}[{}]", place_, i)));
  return out;
}

std::string JsonNode::text() const {
  if (!value_->is_string()) fail("must be a text");
  return value_->get<std::string>();
}

bool JsonNode::truth() const {
  if (!value_->is_boolean()) fail("must be true or false");
  return value_->get<bool>();
}

std::int64_t JsonNode::whole() const {
  if (value_->is_array() && value_->size() == 1) return items().front().whole();
  if (value_->is_number_unsigned() && value_->get<std::uint64_t>() > INT64_MAX) fail("must be below 2^63");
  if (value_->is_number_integer()) return value_->get<std::int64_t>();
  if (value_->is_string()) {
    if (const auto number = numberOf<std::int64_t>(value_->get<std::string>())) return *number;
  }
  if (value_->is_number_float()) {
    constexpr double kExact = 9007199254740992;  // 2^53
    const double number = value_->get<double>();
    if (number == std::floor(number) && std::abs(number) <= kExact) return static_cast<std::int64_t>(number);
  }
  fail("must be a whole number");
}

double JsonNode::number() const {
  if (value_->is_array() && value_->size() == 1) return items().front().number();
  if (value_->is_number()) return value_->get<double>();
  if (value_->is_string()) {
    if (const auto number = numberIn(value_->get<std::string>())) return *number;
  }
  fail("must be a number");
}

namespace {

template <class Get>
auto listOf(const JsonNode& node, Get get) {
  std::vector<decltype(get(node))> out;
  for (const JsonNode& item : node.items()) out.push_back(get(item));
  return out;
}

}  // namespace

std::vector<std::int64_t> JsonNode::wholes() const {
  return listOf(*this, [](const JsonNode& item) { return item.whole(); });
}
std::vector<double> JsonNode::numbers() const {
  return listOf(*this, [](const JsonNode& item) { return item.number(); });
}
std::vector<std::string> JsonNode::texts() const {
  return listOf(*this, [](const JsonNode& item) { return item.text(); });
}

std::string JsonNode::shown() const {
  return inQuotes(value_->is_string() ? value_->get<std::string>()
                                      : value_->dump(-1, ' ', true, json::error_handler_t::replace));
}

void JsonNode::fail(const std::string& what) const {
  const bool is_short = !value_->is_object() && !value_->is_array();
  throw Error(ErrorCode::kFormat, file_, place_, what + (is_short ? fmt::format(" (found {})", shown()) : ""));
}

void JsonNode::unsupported(const std::string& what) const { throw Error(ErrorCode::kUnsupported, file_, place_, what); }

}  // namespace kiln
