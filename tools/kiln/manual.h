// The text of --help in two other forms of an installed program: manual pages and a completion script.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "option_facts.h"

namespace kiln::tool {

/// Returns the page of section 1 for one command, in the language of man(7).
std::string manualPage(const CLI::App& app, const CLI::App& command);
/// Returns the page of the program, with a list of its commands.
std::string manualPage(const CLI::App& app);

/// Returns a script for bash that completes commands, options and words of options; file names elsewhere.
std::string bashCompletion(const CLI::App& app, const OptionFacts& facts);

}  // namespace kiln::tool
