// The text of --help in the two other forms that an installed program has it: manual pages, and what a shell completes.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace kiln::tool {

/// A page of section 1 for one command, in man(7)'s language.
std::string manualPage(const CLI::App& app, const CLI::App& command);
/// The page of the program, which names its commands.
std::string manualPage(const CLI::App& app);

/// A script for bash that completes commands, options and the words that some options take; else file names.
std::string bashCompletion(const CLI::App& app);

}  // namespace kiln::tool
