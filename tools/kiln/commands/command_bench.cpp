#include "base/duration_text.h"
#include "bench/report/report.h"
#include "bench/report/report_text.h"
#include "bench/run_suite.h"
#include "commands.h"
#include "examples.h"
#include "job/transfer_function_choice.h"
#include "output_files.h"
#include "say.h"
#include "source_arguments.h"

namespace kiln::tool {
namespace fs = std::filesystem;
namespace {

struct BenchArguments {
  std::string suite, output;
  bool quick = false;
};

// A report's suite.json may be the next report's suite: the file then gets the text that was read.
void requireInputsApart(const Suite& suite, const fs::path& directory) {
  OutputFiles outputs;
  for (const fs::path& file : reportFiles(directory)) {
    if (file != suiteFileOf(directory)) outputs.add(file);
  }
  outputs.requireNone(suite.path);
  outputs.add(suiteFileOf(directory));
  for (const SuiteCase& c : suite.cases) {
    outputs.requireNone(c.volume);
    if (const auto* const file = std::get_if<fs::path>(&c.transfer_function)) outputs.requireNone(fileOf(*file));
  }
}

void run(const BenchArguments& a, Context& context) {
  Suite suite = readSuite(a.suite);
  if (a.quick) suite = quickened(suite);
  const fs::path directory = a.output;
  requireReportDirectory(directory);
  requireInputsApart(suite, directory);
  const BenchOptions options{storesOf(directory), context.command_line, timeNow()};
  const auto report = [&](const Measurements& m, const MeasuredRun& measured) {
    context.progress.clear();
    sayLines(runText(m, measured));
    std::fflush(stdout);
  };
  const Measurements measurements = runSuite(suite, options, context.progress, report);
  writeReport(measurements, directory);
  context.progress.clear();
  sayLines("\n" + standingsText(measurements));
  say("{}\n", fs::absolute(directory / "report.html").string());
}

}  // namespace

void addBench(CLI::App& app, Context& context) {
  auto a = std::make_shared<BenchArguments>();
  CLI::App* command =
      app.add_subcommand("bench", "Measure the visibility methods over a suite of volumes and write a report.");
  command->add_option("SUITE", a->suite, "What to measure: JSON.")->required();
  command->add_option("-o,--output", a->output, "The report's directory, new or with an earlier report.")->required();
  command->add_flag("--quick", a->quick, "Fewer views and sizes: a look, not a measurement.");
  addExamples(*command, {"kiln bench suite.json -o report --quick"});
  command->callback([a, &context] { context.action = [a, &context] { run(*a, context); }; });
}

}  // namespace kiln::tool
