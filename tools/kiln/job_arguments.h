// The flags of a job on a command line, one per row with a flag in the tables of options.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "job/job_flags.h"

namespace kiln::tool {

inline std::string nameOf(OptionGroup group) { return std::string(kOptionGroupNames[static_cast<std::size_t>(group)]); }

class JobArguments {
 public:
  void addTo(CLI::App& command, OptionGroup group);
  /// Returns true if the flag is on the command line.
  bool has(std::string_view flag) const;
  bool hasAny(std::initializer_list<std::string_view> flags) const;
  std::optional<std::string> text(std::string_view flag) const;
  /// Replaces the options of the job for which a flag is given. throws: Error kUsage naming the flag.
  void apply(RenderJob& job) const;

 private:
  struct Argument {
    const JobFlag* flag;
    const CLI::Option* option;
  };
  std::vector<Argument> arguments_;  // in the order of jobFlags()
};

}  // namespace kiln::tool
