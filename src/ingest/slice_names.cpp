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

struct NumberedName {
  std::string name;
  /// The text before each number, and after the last number.
  std::vector<std::string> texts;
  /// Numbers as written, and without leading zeros ("" is zero).
  std::vector<std::string> digits, numbers;
  /// Position of each number in `name`. unit: bytes.
  std::vector<std::size_t> places;
};

NumberedName numberedName(const std::filesystem::path& path) {
  NumberedName out;
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
std::string patternOf(const NumberedName& name, std::size_t running) {
  std::string out = name.texts.front();
  const bool all = running >= name.numbers.size();
  for (std::size_t i = 0; i < name.numbers.size(); ++i) {
    out += (all || i == running ? "*" : name.digits[i]) + name.texts[i + 1];
  }
  return out;
}

// Returns a sentence about the stacks that the names form.
std::string stacksOf(const std::vector<NumberedName>& names, std::size_t running) {
  constexpr std::size_t kMost = 6;
  std::map<std::string, std::vector<const NumberedName*>> groups;
  for (const NumberedName& name : names) groups[patternOf(name, running)].push_back(&name);
  std::string list;
  std::size_t listed = 0;
  for (const auto& [pattern, members] : groups) {
    if (listed++ == kMost) {
      list += fmt::format(" and {} more", groups.size() - kMost);
      break;
    }
    list += fmt::format("{}{}", listed == 1 ? "" : ", ",
                        members.size() == 1 ? inQuotes(members.front()->name)
                                            : fmt::format("{} ({} files)", inQuotes(pattern), members.size()));
  }
  return fmt::format("the names of its slices form {} groups, not one numbered stack: {}", groups.size(), list);
}

// Returns the distinct values of each number field. requires: equally many numbers in all names.
std::vector<std::set<std::string>> valuesOf(const std::vector<NumberedName>& names) {
  std::vector<std::set<std::string>> out(names.front().numbers.size());
  for (const NumberedName& name : names) {
    for (std::size_t i = 0; i < out.size(); ++i) out[i].insert(name.numbers[i]);
  }
  return out;
}

std::string sameNumber(const NumberedName& a, const NumberedName& b) {
  return fmt::format("{} and {} have the same number", inQuotes(a.name), inQuotes(b.name));
}

// Returns the name of the slice with another number, padded with zeros if the name has leading zeros.
std::string renumbered(const NumberedName& name, std::size_t field, std::int64_t number) {
  const std::string& digits = name.digits[field];
  const bool padded = digits.size() > name.numbers[field].size();
  std::string out = name.name;
  return inQuotes(
      out.replace(name.places[field], digits.size(), fmt::format("{:0{}}", number, padded ? digits.size() : 1)));
}

// Returns a sentence about the first unequal step of one field; empty if all steps are equal.
std::string irregularSteps(const std::vector<NumberedName>& names, std::size_t field) {
  std::vector<std::int64_t> numbers;
  for (const NumberedName& name : names) {
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
    const NumberedName& before = names[first - 1];
    const std::string next = renumbered(before, field, numbers[first - 1] + usual);
    what = step == 2 * usual
               ? next + " is missing"
               : fmt::format("{} to {} are missing", next, renumbered(before, field, numbers[first] - usual));
  }
  return fmt::format("{} is followed by {}: {}{}", inQuotes(names[first - 1].name), inQuotes(names[first].name), what,
                     places > 1 ? fmt::format(" ({} such places)", places) : "");
}

std::string irregularity(const SliceFiles& slices) {
  std::vector<NumberedName> names;
  names.reserve(slices.files.size());
  for (const std::filesystem::path& file : slices.files) names.push_back(numberedName(file));
  const auto unlike = [&](const NumberedName& name) { return name.texts != names.front().texts; };
  if (std::any_of(names.begin(), names.end(), unlike)) return stacksOf(names, SIZE_MAX);
  const std::vector<std::set<std::string>> values = valuesOf(names);
  const auto changes = [](const std::set<std::string>& found) { return found.size() > 1; };
  const auto changing = std::count_if(values.begin(), values.end(), changes);
  const auto fewer = [](const auto& a, const auto& b) { return a.size() < b.size(); };
  const auto field = static_cast<std::size_t>(std::max_element(values.begin(), values.end(), fewer) - values.begin());
  if (changing > 1) return stacksOf(names, field);
  if (changing == 0) return sameNumber(names[0], names[1]);
  return irregularSteps(names, field);
}

// The second number by which names differ, beside the number that counts slices.
struct SecondNumber {
  std::size_t running = 0, field = 0;
};

// Returns the second number if the names differ in two numbers only.
std::optional<SecondNumber> secondNumber(const std::vector<NumberedName>& names) {
  const auto unlike = [&](const NumberedName& name) { return name.texts != names.front().texts; };
  if (std::any_of(names.begin(), names.end(), unlike)) return std::nullopt;
  const std::vector<std::set<std::string>> values = valuesOf(names);
  SecondNumber out;
  std::vector<std::size_t> changing;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (values[i].size() > 1) changing.push_back(i);
  if (changing.size() != 2) return std::nullopt;
  const bool first_runs = values[changing[0]].size() >= values[changing[1]].size();
  out.running = changing[first_runs ? 0 : 1], out.field = changing[first_runs ? 1 : 0];
  return out;
}

std::string withoutZeros(std::string_view number) {
  number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
  return std::string(number);
}

// Keeps the files whose second number is the user's channel or time. Returns without effect if the names have no second
// number.
void chooseByName(SliceFiles& slices, const SourceOptions& options) {
  std::vector<NumberedName> names;
  for (const std::filesystem::path& file : slices.files) names.push_back(numberedName(file));
  const std::optional<SecondNumber> second = secondNumber(names);
  if (!second || (!options.channel && !options.time && options.allow_irregular)) return;
  if (options.channel && options.time)
    throw Error(ErrorCode::kUsage, slices.input, "--time",
                "the names have one number beside the slices' (found --channel, too); leave one of them out");
  const bool by_time = options.time.has_value();
  const char* const option = by_time ? "--time" : "--channel";
  if (!options.channel && !options.time)
    throw Error(ErrorCode::kUsage, slices.input, "",
                stacksOf(names, second->running) + "; choose one by its number with --channel or --time");
  const std::string wanted = by_time ? std::to_string(*options.time) : *options.channel;
  std::vector<std::filesystem::path> kept;
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i].numbers[second->field] == withoutZeros(wanted)) kept.push_back(slices.files[i]);
  if (kept.empty())
    throw Error(ErrorCode::kUsage, slices.input, option,
                "no name has the number " + inQuotes(wanted) + "; " + stacksOf(names, second->running));
  slices.files = std::move(kept);
  slices.part = fmt::format(", {} {}", by_time ? "time" : "channel", wanted);
}

}  // namespace

std::vector<std::vector<std::filesystem::path>> stacksByName(const std::vector<std::filesystem::path>& files) {
  // Files whose names have equal texts between their numbers are compared number by number.
  std::map<std::vector<std::string>, std::vector<NumberedName>> alike;
  for (const std::filesystem::path& file : files) {
    const NumberedName name = numberedName(file);
    alike[name.texts].push_back(name);
  }
  std::map<std::string, std::size_t> running;  // by pattern of all numbers
  for (const auto& [texts, names] : alike) {
    const std::vector<std::set<std::string>> values = valuesOf(names);
    const auto fewer = [](const auto& a, const auto& b) { return a.size() < b.size(); };
    running[patternOf(names.front(), SIZE_MAX)] =
        static_cast<std::size_t>(std::max_element(values.begin(), values.end(), fewer) - values.begin());
  }
  std::map<std::string, std::vector<std::filesystem::path>> stacks;
  for (const std::filesystem::path& file : files) {
    const NumberedName name = numberedName(file);
    stacks[patternOf(name, running.at(patternOf(name, SIZE_MAX)))].push_back(file);
  }
  std::vector<std::vector<std::filesystem::path>> out;
  for (auto& [pattern, members] : stacks) out.push_back(std::move(members));
  return out;
}

void requireOneStack(SliceFiles& slices, const SourceOptions& options) {
  if (slices.files.size() < 2) return;
  chooseByName(slices, options);
  if (slices.files.size() < 2) return;
  const std::string what = irregularity(slices);
  if (what.empty()) return;
  if (!options.allow_irregular) {
    throw Error(ErrorCode::kFormat, slices.input, "",
                what + "; --allow-irregular takes all files in the order of their names");
  }
  slices.notes.push_back(what + "; took all files in the order of their names");
}

}  // namespace kiln
