// The commands of the program, one file each. Each command adds itself to the command line and sets the action to run.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "cluster/ranks.h"
#include "option_facts.h"
#include "terminal_progress.h"

namespace kiln::tool {

struct Context {
  TerminalProgress progress;
  OptionFacts facts;             // of the options of all commands
  std::string command_line;      // for the manifest
  std::function<void()> action;  // runs the chosen command
  Ranks* ranks = nullptr;        // one rank; several under mpirun
  bool by_all_ranks = false;     // all ranks run the action; else the first rank, while the others wait
  double rank_timeout_s = 300;   // a rank idle for longer ends the run; 0: never. unit: s
};

/// Adds --rank-timeout to a command that all ranks run.
CLI::Option* addRankTimeout(CLI::App& command, Context& context);

void addConvert(CLI::App& app, Context& context);
void addInfo(CLI::App& app, Context& context);
void addVerify(CLI::App& app, Context& context);
void addExport(CLI::App& app, Context& context);
void addSlice(CLI::App& app, Context& context);
void addGallery(CLI::App& app, Context& context);
void addTf(CLI::App& app, Context& context);
void addRender(CLI::App& app, Context& context);
void addView(CLI::App& app, Context& context);
void addSplit(CLI::App& app, Context& context);
void addComposite(CLI::App& app, Context& context);
void addCompare(CLI::App& app, Context& context);
void addSchema(CLI::App& app, Context& context);
void addManual(CLI::App& app, Context& context);
void addBench(CLI::App& app, Context& context);

}  // namespace kiln::tool
