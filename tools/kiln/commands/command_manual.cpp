#include <fmt/format.h>

#include "base/file/file.h"
#include "commands.h"
#include "examples.h"
#include "manual.h"
#include "store/store_reader.h"

namespace kiln::tool {
namespace {
namespace fs = std::filesystem;

void writeManual(const CLI::App& app, const OptionFacts& facts, const fs::path& share) {
  FileSystem& disk = FileSystem::real();
  const fs::path pages = share / "man" / "man1", completions = share / "bash-completion" / "completions";
  requireOutsideStores(pages, "DIR");
  disk.makeDirectories(pages);
  disk.makeDirectories(completions);
  disk.writeAtomic(pages / "kiln.1", manualPage(app));
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    disk.writeAtomic(pages / fmt::format("kiln-{}.1", command->get_name()), manualPage(app, *command));
  disk.writeAtomic(completions / "kiln", bashCompletion(app, facts));
}

}  // namespace

void addManual(CLI::App& app, Context& context) {
  auto share = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand("manual", "Write the manual pages and what bash completes.");
  command
      ->add_option("DIR", *share,
                   "A directory such as /usr/local/share: DIR/man/man1, DIR/bash-completion/completions.")
      ->required();
  addExamples(*command, {"kiln manual share"});
  command->callback([&app, share, &context] {
    context.action = [&app, share, &context] { writeManual(app, context.facts, *share); };
  });
}

}  // namespace kiln::tool
