// Two channels per slice, or a missing slice, would become a volume with wrong distances and no error. Formats with
// positions of their own (DICOM) do not need this check.
#include "ingest/slice_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "base/error.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

struct NameWithNumbers {
  std::filesystem::path path;
  /// The name of the file.
  std::string name;
  /// The text before each number, and after the last number.
  std::vector<std::string> texts;
  /// Numbers as written, and without leading zeros ("" is zero).
  std::vector<std::string> digits, numbers;
  /// Position of each number in `name`. unit: bytes.
  std::vector<std::size_t> places;
};

NameWithNumbers numbersOf(const std::filesystem::path& path) {
  NameWithNumbers out;
  out.path = path;
  out.name = path.filename().string();
  out.texts.emplace_back();
  bool in_number = false;
  for (std::size_t i = 0; i < out.name.size(); ++i) {
    const char c = out.name[i];
    const bool digit = c >= '0' && c <= '9';
    if (digit && !in_number) {
      out.numbers.emplace_back();
      out.digits.emplace_back();
      out.places.push_back(i);
    }
    if (!digit && in_number) out.texts.emplace_back();
    in_number = digit;
    if (!digit) out.texts.back() += c;
    if (digit) out.digits.back() += c;
    if (digit && (c != '0' || !out.numbers.back().empty())) out.numbers.back() += c;
  }
  if (in_number) out.texts.emplace_back();
  return out;
}

// Returns the name with `*` for the number at index `running`, or for all numbers if the index is beyond them.
std::string patternOf(const NameWithNumbers& name, std::size_t running) {
  std::string out = name.texts.front();
  const bool all = running >= name.numbers.size();
  for (std::size_t i = 0; i < name.numbers.size(); ++i) {
    out += (all || i == running ? "*" : name.digits[i]) + name.texts[i + 1];
  }
  return out;
}

// Returns a sentence about the stacks that the names form.
std::string stacksOf(const std::vector<NameWithNumbers>& names, std::size_t running) {
  constexpr std::size_t kMostListed = 6;
  std::map<std::string, std::vector<const NameWithNumbers*>> groups;
  for (const NameWithNumbers& name : names) groups[patternOf(name, running)].push_back(&name);
  std::string list;
  std::size_t listed = 0;
  for (const auto& [pattern, members] : groups) {
    if (listed++ == kMostListed) {
      list += fmt::format(" and {} more", groups.size() - kMostListed);
      break;
    }
    list += fmt::format("{}{}", listed == 1 ? "" : ", ",
                        members.size() == 1 ? inQuotes(members.front()->name)
                                            : fmt::format("{} ({} files)", inQuotes(pattern), members.size()));
  }
  return fmt::format("the names of its slices form {} groups, not one numbered stack: {}", groups.size(), list);
}

// The names of files, and the values of the numbers in them.
struct NumberedNames {
  explicit NumberedNames(std::vector<NameWithNumbers> members);
  explicit NumberedNames(const std::vector<std::filesystem::path>& files) : NumberedNames(namesOf(files)) {}

  /// Indices of the numbers by which the names differ.
  std::vector<std::size_t> changing() const;
  /// The number that counts slices: the first one with the most values.
  std::size_t running() const;

  std::vector<NameWithNumbers> names;
  /// True if all names have the same texts between their numbers.
  bool alike;
  /// The distinct values of each number; empty unless the names are alike.
  std::vector<std::set<std::string>> values;

 private:
  static std::vector<NameWithNumbers> namesOf(const std::vector<std::filesystem::path>& files) {
    std::vector<NameWithNumbers> out;
    for (const std::filesystem::path& file : files) out.push_back(numbersOf(file));
    return out;
  }
};

NumberedNames::NumberedNames(std::vector<NameWithNumbers> members) : names(std::move(members)) {
  alike = std::all_of(names.begin(), names.end(),
                      [&](const NameWithNumbers& name) { return name.texts == names.front().texts; });
  if (!alike || names.empty()) return;
  values.resize(names.front().numbers.size());
  for (const NameWithNumbers& name : names)
    for (std::size_t i = 0; i < values.size(); ++i) values[i].insert(name.numbers[i]);
}

std::vector<std::size_t> NumberedNames::changing() const {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i].size() > 1) out.push_back(i);
  return out;
}

std::size_t NumberedNames::running() const {
  const auto fewer = [](const auto& a, const auto& b) { return a.size() < b.size(); };
  return static_cast<std::size_t>(std::max_element(values.begin(), values.end(), fewer) - values.begin());
}

std::string sameNumber(const NameWithNumbers& a, const NameWithNumbers& b) {
  return fmt::format("{} and {} have the same number", inQuotes(a.name), inQuotes(b.name));
}

// Returns the name of the slice with another number, padded with zeros if the name has leading zeros.
std::string renumbered(const NameWithNumbers& name, std::size_t field, std::int64_t number) {
  const std::string& digits = name.digits[field];
  const bool padded = digits.size() > name.numbers[field].size();
  std::string out = name.name;
  return inQuotes(
      out.replace(name.places[field], digits.size(), fmt::format("{:0{}}", number, padded ? digits.size() : 1)));
}

// Returns a sentence about the first unequal step of one field; empty if all steps are equal.
std::string irregularSteps(const std::vector<NameWithNumbers>& names, std::size_t field) {
  std::vector<std::int64_t> numbers;
  for (const NameWithNumbers& name : names) {
    const std::string& text = name.numbers[field];
    const auto number = text.empty() ? 0 : integerOf(text);
    if (!number) return fmt::format("the number in {} is too long to be the number of a slice", inQuotes(name.name));
    numbers.push_back(*number);
  }
  const auto equal = std::adjacent_find(numbers.begin(), numbers.end());
  if (equal != numbers.end()) {
    const auto at = static_cast<std::size_t>(equal - numbers.begin());
    return sameNumber(names[at], names[at + 1]);
  }
  std::map<std::int64_t, std::size_t> steps;
  for (std::size_t i = 1; i < numbers.size(); ++i) ++steps[numbers[i] - numbers[i - 1]];
  if (steps.size() == 1) return "";
  const auto rarer = [](const auto& a, const auto& b) { return a.second < b.second; };
  const std::int64_t usual = std::max_element(steps.begin(), steps.end(), rarer)->first;
  std::size_t first = 0, places = 0;
  for (std::size_t i = 1; i < numbers.size(); ++i) {
    if (numbers[i] - numbers[i - 1] != usual && places++ == 0) first = i;
  }
  const std::int64_t step = numbers[first] - numbers[first - 1];
  std::string what = fmt::format("a step of {} where others are {}", step, usual);
  if (step % usual == 0) {
    const NameWithNumbers& before = names[first - 1];
    const std::string next = renumbered(before, field, numbers[first - 1] + usual);
    what = step == 2 * usual
               ? next + " is missing"
               : fmt::format("{} to {} are missing", next, renumbered(before, field, numbers[first] - usual));
  }
  return fmt::format("{} is followed by {}: {}{}", inQuotes(names[first - 1].name), inQuotes(names[first].name), what,
                     places > 1 ? fmt::format(" ({} such places)", places) : "");
}

std::string irregularity(const NumberedNames& numbered) {
  if (!numbered.alike) return stacksOf(numbered.names, SIZE_MAX);
  const std::size_t changing = numbered.changing().size();
  if (changing > 1) return stacksOf(numbered.names, numbered.running());
  if (changing == 0) return sameNumber(numbered.names[0], numbered.names[1]);
  return irregularSteps(numbered.names, numbered.running());
}

// Returns the second number by which the names differ, beside the number that counts slices; nothing if they differ in
// fewer numbers or more.
std::optional<std::size_t> secondNumber(const NumberedNames& numbered) {
  const std::vector<std::size_t> changing = numbered.changing();
  if (changing.size() != 2) return std::nullopt;
  return changing[numbered.running() == changing[0] ? 1 : 0];
}

std::string withoutZeros(std::string_view number) {
  number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
  return std::string(number);
}

// Keeps the files whose second number is the user's channel or time. Returns without effect if the names have no second
// number.
void chooseByName(SliceFiles& slices, NumberedNames& numbered, const SourceOptions& options) {
  const std::optional<std::size_t> second = secondNumber(numbered);
  if (!second || (!options.channel && !options.time && options.allow_irregular)) return;
  if (options.channel && options.time)
    throw Error(ErrorCode::kUsage, slices.input, "--time",
                "the names have one number beside the slices' (found --channel, too); leave one of them out");
  const bool by_time = options.time.has_value();
  const char* const option = by_time ? "--time" : "--channel";
  const std::string stacks = stacksOf(numbered.names, numbered.running());
  if (!options.channel && !options.time)
    throw Error(ErrorCode::kUsage, slices.input, "", stacks + "; choose one by its number with --channel or --time");
  const std::string wanted = by_time ? std::to_string(*options.time) : *options.channel;
  std::vector<NameWithNumbers> kept;
  for (const NameWithNumbers& name : numbered.names)
    if (name.numbers[*second] == withoutZeros(wanted)) kept.push_back(name);
  if (kept.empty())
    throw Error(ErrorCode::kUsage, slices.input, option, "no name has the number " + inQuotes(wanted) + "; " + stacks);
  slices.files.clear();
  for (const NameWithNumbers& name : kept) slices.files.push_back(name.path);
  slices.part = fmt::format(", {} {}", by_time ? "time" : "channel", wanted);
  numbered = NumberedNames(std::move(kept));
}

}  // namespace

std::vector<std::vector<std::filesystem::path>> stacksByName(const std::vector<std::filesystem::path>& files) {
  // Files whose names have equal texts between their numbers are compared number by number.
  std::map<std::vector<std::string>, std::vector<NameWithNumbers>> alike;
  for (const std::filesystem::path& file : files) {
    NameWithNumbers name = numbersOf(file);
    std::vector<NameWithNumbers>& members = alike[name.texts];
    members.push_back(std::move(name));
  }
  std::map<std::string, std::vector<std::filesystem::path>> stacks;
  for (auto& [texts, members] : alike) {
    const NumberedNames numbered(std::move(members));
    for (const NameWithNumbers& name : numbered.names) stacks[patternOf(name, numbered.running())].push_back(name.path);
  }
  std::vector<std::vector<std::filesystem::path>> out;
  for (auto& [pattern, members] : stacks) out.push_back(std::move(members));
  return out;
}

std::vector<std::string> numbersOfStacks(const std::vector<std::filesystem::path>& files,
                                         const std::vector<std::vector<std::filesystem::path>>& stacks) {
  std::vector<std::string> out;
  const std::optional<std::size_t> second = secondNumber(NumberedNames(files));
  for (std::size_t i = 0; second && i < stacks.size(); ++i) {
    const std::string number = numbersOf(stacks[i].front()).numbers[*second];
    out.push_back(number.empty() ? "0" : number);
  }
  return out;
}

void requireOneStack(SliceFiles& slices, const SourceOptions& options) {
  if (slices.files.size() < 2) return;
  NumberedNames numbered(slices.files);
  chooseByName(slices, numbered, options);
  if (slices.files.size() < 2) return;
  const std::string what = irregularity(numbered);
  if (what.empty()) return;
  if (!options.allow_irregular) {
    throw Error(ErrorCode::kFormat, slices.input, "",
                what + "; --allow-irregular takes all files in the order of their names");
  }
  slices.notes.push_back(what + "; took all files in the order of their names");
}

}  // namespace kiln
