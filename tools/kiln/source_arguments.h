// Options for properties that a foreign file lacks, such as the dimensions of raw data; and validators of numbers.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>

#include "base/text.h"
#include "ingest/source_words.h"
#include "job/render_job.h"
#include "option_facts.h"

namespace kiln::tool {

/// Validates a whole number from `least` to `most`.
CLI::Validator wholeNumberFrom(int least, std::int64_t most = INT64_MAX);

/// Validates a finite number from `least` to `most`.
CLI::Validator numberFrom(double least, double most);

/// Validates a word of `words`, which outlive the validator.
CLI::Validator oneOf(std::span<const std::string_view> words);

/// Validates a number in decimal digits that T can hold. CLI11 itself also takes nan, infinities, blanks, hexadecimal
/// and octal numbers.
template <class T>
CLI::Validator decimalNumber() {
  const auto refused = [](std::string& text) {
    if (decimalOf<T>(text)) return std::string();
    return fmt::format("expected a {}number, found '{}'", std::is_integral_v<T> ? "whole " : "", text);
  };
  return {refused, ""};
}

/// Adds an option with a decimal number. `value` is a number or a std::optional of a number.
template <class T>
CLI::Option* addNumber(CLI::App& command, const std::string& name, T& value, const std::string& help) {
  return command.add_option(name, value, help)->check(decimalNumber<T>());
}
template <class T>
CLI::Option* addNumber(CLI::App& command, const std::string& name, std::optional<T>& value, const std::string& help) {
  return command.add_option(name, value, help)->check(decimalNumber<T>());
}

/// Adds an option for each word of the source.
void addSourceArguments(CLI::App& command, OptionFacts& facts, SourceWords& source);

/// Adds the option --memory. `text` is a std::string with the default, or a std::optional if a job may set the memory.
/// `holds` stands in the help text "Most memory, for ….".
template <class Text>
CLI::Option* addMemory(CLI::App& command, Text& text, const std::string& holds) {
  return command.add_option("--memory", text, "Most memory, for " + holds + ".")->type_name("BYTES");
}

/// Adds the flag --quiet of commands that convert.
inline void addQuiet(CLI::App& command, bool& quiet) {
  command.add_flag("--quiet", quiet, "Print no progress and no report, but notes, warnings and errors.");
}

inline constexpr const char* kDefaultMemory = "2G";

/// Returns the finite numbers between separators. throws: Error kUsage "OPTION: expected …, found …".
std::vector<double> parseNumbers(const std::string& text, char separator, const char* option, const char* expected);
/// Returns the two integers of "AxB" or "A,B". unit: pixels. throws: Error kUsage naming `option`.
std::pair<int, int> parseSize(const std::string& text, const char* option);
/// throws: Error kUsage if the file is a volume and no store. The message names the expected kind of file (`wanted`,
/// such as "a picture") and the commands that convert and draw the volume.
void refuseVolumeFile(const std::filesystem::path& path, const char* wanted);

}  // namespace kiln::tool
