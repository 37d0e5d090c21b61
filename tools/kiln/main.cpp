// The program: reads the command line, runs one command, and turns every failure into one line and an exit code:
// 0 done, 1 data or I/O, 2 command line.
#include <cstdio>
#include <new>

#include "base/error.h"
#include "commands.h"

namespace {

int run(int argc, char** argv) {
  using namespace kiln::tool;
  CLI::App app("Kiln renders scalar volumes larger than memory, on CPUs, from the command line.", "kiln");
  app.set_version_flag("--version", std::string("kiln ") + KILN_VERSION);
  app.require_subcommand(1);
  Context context;
  for (int i = 0; i < argc; ++i) context.command_line += (i == 0 ? "" : " ") + std::string(i == 0 ? "kiln" : argv[i]);
  addConvert(app, context);
  addInfo(app, context);
  addVerify(app, context);
  addExport(app, context);
  addSlice(app, context);
  addTf(app, context);
  addRender(app, context);
  addComposite(app, context);
  addCompare(app, context);
  addSchema(app, context);
  addBench(app, context);
  addManual(app, context);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    if (app.get_subcommands().empty() && !app.remaining().empty()) {
      std::fprintf(stderr, "kiln: there is no command or option '%s'; run 'kiln --help'\n",
                   app.remaining().front().c_str());
      return 2;
    }
    std::fprintf(stderr, "kiln: %s; run 'kiln --help' or 'kiln COMMAND --help'\n", error.what());
    return 2;
  }
  installInterruptHandler();
  try {
    context.action();
    return 0;
  } catch (const kiln::Error& error) {
    context.progress.clear();
    std::fprintf(stderr, "kiln: %s\n", error.what());
    return error.exitCode();
  } catch (const std::bad_alloc&) {
    context.progress.clear();
    std::fprintf(stderr, "kiln: the machine has no more memory to give; lower --memory or the image's size\n");
    return 1;
  }
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "kiln: unexpected: %s; this is a defect, please report it\n", error.what());
    return 1;
  }
}
