// The flags of a job on a command line, one per row with a flag in the tables of options.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "job/command/given_flags.h"
#include "option_facts.h"

namespace kiln::tool {

inline std::string nameOf(OptionGroup group) { return std::string(kOptionGroupNames[static_cast<std::size_t>(group)]); }

class JobArguments {
 public:
  /// Adds the flags of a group, but for the flag `left_out`, and notes their facts.
  void addTo(CLI::App& command, OptionFacts& facts, OptionGroup group, std::string_view left_out = {});
  /// Returns the flags that are on the command line.
  GivenFlags given() const;

 private:
  struct Argument {
    const JobFlag* flag;
    const CLI::Option* option;
  };
  std::vector<Argument> arguments_;  // in the order of jobFlags()
};

}  // namespace kiln::tool
