// The known word that a misspelt one probably means, for error messages.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace kiln {

/// The word of `known` with the least edit distance to `word`. requires: known is not empty.
std::string_view nearestWord(std::string_view word, std::span<const std::string_view> known);

/// Returns the first word of `known` that begins with `word`; else the nearest word, if the edits are at most one and a
/// third of the letters of `word`; else the first word with which `word` begins; else nothing.
std::optional<std::string_view> meantWord(std::string_view word, std::span<const std::string_view> known);

/// Returns "; did you mean 'ct-bone'?", the end of a sentence that refuses `word`; empty without a meant word.
std::string meantWordHint(std::string_view word, std::span<const std::string_view> known);

}  // namespace kiln
