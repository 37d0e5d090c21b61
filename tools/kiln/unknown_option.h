// Refusals of unknown commands, of options that a command does not have, of options given twice, and of words beyond
// those that it takes.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace kiln::tool {

/// Returns "there is no command or option 'reder'; did you mean 'render'?" for the first word of a command line.
std::string unknownCommandText(const CLI::App& app, const std::string& word);

/// Returns "--bg: is no option of kiln render; --background?" for the first unexpected option of a command, or
/// "convert: expected INPUT and OUT (found a b c); ..." for unexpected words; empty if all words were expected. Names
/// of other programs' options lead to the options of the same meaning.
std::string unknownOptionText(const CLI::App& app);

/// Returns "--look: takes one value (found plain and studio); give the option once" for the first option with more
/// values than it takes; empty if there is none.
std::string repeatedOptionText(const CLI::App& app);

}  // namespace kiln::tool
