// Header bytes are hostile. A line is limited before it is stored, and a number must fill its word. std::from_chars
// reads a decimal point in every locale.
#include "ingest/source/header_text.h"

#include <algorithm>
#include <cctype>

namespace kiln {
namespace {

constexpr std::size_t kHeaderStepBytes = 1 << 14;
constexpr std::size_t kMaxLineBytes = 1 << 20;
constexpr std::uint64_t kMaxHeaderBytes = 16u << 20;

template <class T>
std::vector<T> numbers(const HeaderFields& fields, const HeaderField& field, std::size_t count) {
  const std::vector<std::string> parts = words(field.value);
  if (parts.size() != count) {
    fields.fail(field, std::to_string(parts.size()) + " values, " + std::to_string(count) + " are expected");
  }
  std::vector<T> out;
  for (const std::string& part : parts) {
    const std::optional<T> value = signedNumberOf<T>(part);
    if (!value) fields.fail(field, inQuotes(part) + " is not a number that is legal here");
    out.push_back(*value);
  }
  return out;
}

// True for a pattern like "slice%03d.raw 1 10 1". requires: at least one word.
bool isPattern(const std::vector<std::string>& parts) {
  return parts.size() >= 4 && parts[0].find('%') != std::string::npos && integerOf(parts[1]) && integerOf(parts[2]) &&
         integerOf(parts[3]);
}

/// A name with one number of at least `width` digits between two texts.
struct NumberedFile {
  std::string before, after;
  std::size_t width = 1;
  bool zeros = false;

  std::string of(std::int64_t number) const {
    std::string digits = std::to_string(number);
    if (digits.size() < width) digits.insert(number < 0 && zeros ? 1 : 0, width - digits.size(), zeros ? '0' : ' ');
    return before + digits + after;
  }
};

// Parses printf's conversion of a whole number, %d, %3d or %03d; nothing for other conversions, and for several.
std::optional<NumberedFile> numberedFile(const std::string& pattern) {
  constexpr std::size_t kWidest = 20;
  NumberedFile out;
  std::size_t at = pattern.find('%');
  out.before = pattern.substr(0, at);
  out.zeros = ++at < pattern.size() && pattern[at] == '0';
  std::size_t width = 0;
  for (; at < pattern.size() && std::isdigit(static_cast<unsigned char>(pattern[at])) != 0 && width <= kWidest; ++at)
    width = 10 * width + static_cast<std::size_t>(pattern[at] - '0');
  if (at >= pattern.size() || std::string_view("diu").find(pattern[at]) == std::string_view::npos || width > kWidest)
    return std::nullopt;
  out.width = std::max<std::size_t>(width, 1);
  out.after = pattern.substr(at + 1);
  if (out.after.find('%') != std::string::npos) return std::nullopt;
  return out;
}

}  // namespace

bool HeaderLines::refill() {
  if (offset_ - begin_ + (buffer_.size() - used_) > kMaxHeaderBytes || buffer_.size() - used_ > kMaxLineBytes) {
    throw Error(ErrorCode::kFormat, file_.path(), "line " + std::to_string(number_),
                "the text header has no end; the file is damaged, or of another format than its first line");
  }
  buffer_.erase(0, std::exchange(used_, 0));
  const std::size_t held = buffer_.size();
  buffer_.resize(held + kHeaderStepBytes);
  const std::size_t got =
      file_.readSomeAt(offset_ + held, std::as_writable_bytes(std::span(buffer_.data() + held, kHeaderStepBytes)));
  buffer_.resize(held + got);
  return got > 0;
}

std::optional<std::string> HeaderLines::next() {
  ++number_;
  std::size_t end;
  while ((end = buffer_.find('\n', used_)) == std::string::npos) {
    if (refill()) continue;
    if (used_ == buffer_.size()) return std::nullopt;
    end = buffer_.size();
    break;
  }
  std::string line = buffer_.substr(used_, end - used_);
  const std::size_t after = std::min(end + 1, buffer_.size());
  offset_ += after - used_;
  used_ = after;
  if (!line.empty() && line.back() == '\r') line.pop_back();
  return line;
}

std::vector<std::string> HeaderLines::rest() {
  std::vector<std::string> out;
  while (const std::optional<std::string> line = next())
    if (std::string text = trimmed(*line); !text.empty()) out.push_back(std::move(text));
  return out;
}

void HeaderFields::add(HeaderField field, bool same_again) {
  if (const HeaderField* first = find(field.key)) {
    const bool spelling = first->written != field.written;
    if (!(same_again && spelling && first->value == field.value)) {
      fail(field, (spelling ? "contradicts " + inQuotes(first->written) + " in line " : "is given already in line ") +
                      std::to_string(first->line));
    }
    return;
  }
  fields_.push_back(std::move(field));
}

const HeaderField* HeaderFields::find(std::string_view key) const {
  const auto found = std::find_if(fields_.begin(), fields_.end(), [&](const HeaderField& f) { return f.key == key; });
  return found == fields_.end() ? nullptr : &*found;
}

const HeaderField& HeaderFields::require(std::string_view key) const {
  if (const HeaderField* field = find(key)) return *field;
  throw Error(ErrorCode::kFormat, path_, "header", "the field '" + std::string(key) + "' is missing");
}

void HeaderFields::fail(const HeaderField& field, const std::string& what, ErrorCode code) const {
  throw Error(code, path_, "line " + std::to_string(field.line), field.written + ": " + what);
}

std::vector<double> HeaderFields::doubles(const HeaderField& field, std::size_t count) const {
  return numbers<double>(*this, field, count);
}

std::vector<std::int64_t> HeaderFields::integers(const HeaderField& field, std::size_t count) const {
  return numbers<std::int64_t>(*this, field, count);
}

Extent3 HeaderFields::extent(const HeaderField& field) const {
  const std::vector<std::int64_t> n = integers(field, 3);
  return {n[0], n[1], n[2]};
}

glm::dvec3 HeaderFields::vector(const HeaderField& field) const {
  const std::vector<double> v = doubles(field, 3);
  return {v[0], v[1], v[2]};
}

void HeaderFields::dropAxes(std::string_view key, const std::vector<bool>& dropped) {
  const HeaderField* field = find(key);
  if (field == nullptr) return;
  const std::vector<std::string> values = axisValues(field->value);
  if (values.size() != dropped.size())
    fail(*field, std::to_string(values.size()) + " values, " + std::to_string(dropped.size()) + " are expected");
  std::string kept;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!dropped[i]) kept += (kept.empty() ? "" : " ") + values[i];
  replace(key, std::move(kept));
}

void HeaderFields::replace(std::string_view key, std::string value) {
  const auto found = std::find_if(fields_.begin(), fields_.end(), [&](const HeaderField& f) { return f.key == key; });
  found->value = std::move(value);
}

bool namesList(std::string_view value) { return value == "LIST" || value.starts_with("LIST "); }

std::vector<std::string> HeaderFields::namesOf(const HeaderField& field, const std::vector<std::string>& listed) const {
  constexpr std::int64_t kMostFiles = 1'000'000;
  if (namesList(field.value)) {
    if (listed.empty()) fail(field, "the list names no data file");
    return listed;
  }
  const std::vector<std::string> parts = words(field.value);
  if (parts.empty()) fail(field, "names no data file");
  if (!isPattern(parts)) return {field.value};
  const std::optional<NumberedFile> file = numberedFile(parts[0]);
  if (!file) fail(field, inQuotes(parts[0]) + " is no pattern with one number such as %d or %03d");
  const std::int64_t first = *integerOf(parts[1]), last = *integerOf(parts[2]), step = *integerOf(parts[3]);
  const bool far = std::max(std::abs(static_cast<double>(first)), std::abs(static_cast<double>(last))) > 1e15;
  const bool away = last != first && (last > first) != (step > 0);
  if (far || step == 0 || away || (last - first) / step >= kMostFiles)
    fail(field, inQuotes(field.value) + " counts no files, or more than a million");
  std::vector<std::string> out;
  for (std::int64_t i = 0; i <= (last - first) / step; ++i) out.push_back(file->of(first + i * step));
  return out;
}

std::vector<std::filesystem::path> HeaderFields::dataFiles(const HeaderField& field,
                                                           const std::vector<std::string>& listed) const {
  std::vector<std::filesystem::path> out;
  for (const std::string& name : namesOf(field, listed)) out.push_back(dataFile(field, name));
  return out;
}

std::filesystem::path HeaderFields::dataFile(const HeaderField& field, const std::string& name) const {
  if (words(name).empty() || name.find('\0') != std::string::npos) fail(field, "names no data file");
  const std::filesystem::path file = path_.parent_path() / name;
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (status.type() == std::filesystem::file_type::not_found) {
    fail(field, "the data file " + inQuotes(name) + " is missing; move it to the place that the header names",
         ErrorCode::kNotFound);
  }
  if (status.type() == std::filesystem::file_type::none) {
    fail(field, "the data file " + inQuotes(name) + " cannot be examined: " + error.message(), ErrorCode::kIo);
  }
  if (!std::filesystem::is_regular_file(status)) {
    const bool folder = std::filesystem::is_directory(status);
    fail(field, inQuotes(name) + (folder ? " is a folder" : " is a pipe or a device") +
                    "; name the regular file that holds the voxels");
  }
  if (std::filesystem::equivalent(file, path_, error))
    fail(field, inQuotes(name) + " is this header itself; name the file that holds the voxels");
  return file;
}

std::string trimmed(std::string_view text) {
  // Independent of the locale.
  const auto space = [](char c) { return std::string_view(" \t\n\v\f\r").find(c) != std::string_view::npos; };
  while (!text.empty() && space(text.front())) text.remove_prefix(1);
  while (!text.empty() && space(text.back())) text.remove_suffix(1);
  return std::string(text);
}

std::vector<std::string> words(std::string_view text) {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < text.size();) {
    const std::size_t first = text.find_first_not_of(" \t\r\v\f", i);
    if (first == std::string_view::npos) break;
    const std::size_t end = std::min(text.find_first_of(" \t\r\v\f", first), text.size());
    out.emplace_back(text.substr(first, end - first));
    i = end;
  }
  return out;
}

std::vector<std::string> axisValues(std::string_view text) {
  constexpr const char* kSpace = " \t\r\v\f";
  std::vector<std::string> out;
  for (std::size_t i = 0; (i = text.find_first_not_of(kSpace, i)) != std::string_view::npos;) {
    const char first = text[i];
    const std::size_t closing = first == '"'   ? text.find('"', i + 1)
                                : first == '(' ? text.find(')', i + 1)
                                               : text.find_first_of(kSpace, i);
    const bool marked = first == '"' || first == '(';
    const std::size_t end = std::min(marked && closing != std::string_view::npos ? closing + 1 : closing, text.size());
    out.emplace_back(text.substr(i, end - i));
    i = end;
  }
  return out;
}

std::optional<double> doubleOf(std::string_view text) { return signedNumberOf<double>(text); }
std::optional<std::int64_t> integerOf(std::string_view text) { return signedNumberOf<std::int64_t>(text); }

namespace {

// Returns the size of the first character if a terminal can show it; 0 for invalid bytes and control characters.
// unit: bytes.
std::size_t shownBytes(std::string_view text) {
  const std::size_t bytes = bytesOfCharacter(text);
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const bool control = bytes == 1 ? byte(0) < 0x20 || byte(0) == 0x7f : bytes == 2 && byte(0) == 0xc2 && byte(1) < 0xa0;
  return control ? 0 : bytes;
}

}  // namespace

std::string inQuotes(std::string_view text) {
  constexpr std::size_t kMost = 60;
  std::string out = "'";
  std::string_view rest = text;
  while (!rest.empty() && text.size() - rest.size() < kMost) {
    const std::size_t count = shownBytes(rest);
    out += count == 0 ? "?" : rest.substr(0, count);
    rest.remove_prefix(std::max<std::size_t>(count, 1));
  }
  return out + (rest.empty() ? "'" : "...'");
}

bool mayBeChannels(const Extent3& dims) { return dims.x >= 2 && dims.x <= 4 && dims.y >= 16 && dims.z >= 16; }

void refuseSpacing(const std::filesystem::path& file) {
  throw Error(ErrorCode::kUsage, file, "--spacing",
              "needs a file without positions of its voxels (this file has positions); leave the option out");
}

glm::dmat4 axesAffine(const glm::dvec3& spacing, const glm::dvec3& origin) {
  return directionsAffine({glm::dvec3(spacing.x, 0, 0), glm::dvec3(0, spacing.y, 0), glm::dvec3(0, 0, spacing.z)},
                          origin);
}

glm::dmat4 directionsAffine(const std::array<glm::dvec3, 3>& directions, const glm::dvec3& origin) {
  return {glm::dvec4(directions[0], 0), glm::dvec4(directions[1], 0), glm::dvec4(directions[2], 0),
          glm::dvec4(origin, 1)};
}

}  // namespace kiln
