#include "base/file.h"
#include "base/memory/memory.h"
#include "commands.h"
#include "convert/export_vdb.h"
#include "examples.h"
#include "output_files.h"
#include "say.h"
#include "source_arguments.h"

namespace kiln::tool {
namespace {

struct ExportArguments {
  std::string store, output, memory = kDefaultMemory;
  int level = 0;
  bool overwrite = false;
};

void run(const ExportArguments& a, Context& context) {
  if (extensionOf(a.output) != ".vdb")
    throw Error(ErrorCode::kUsage, a.output, "", "is no name of an OpenVDB file; write NAME.vdb");
  OutputFiles outputs;
  outputs.add(a.output, "OUT");
  outputs.requireNone(a.store);
  refuseVolumeFile(a.store, "a store");
  const std::uint64_t memory_bytes = parseBytes(a.memory, "--memory");
  const StoreReader store(a.store, memory_bytes);
  store.requireLevel(a.level);
  const ExportReport report =
      exportVdb(store, a.level, a.output, context.progress, FileSystem::real(), a.overwrite, memory_bytes);
  context.progress.clear();
  say("{}: {} active voxels, {}\n", a.output, report.voxels, formatBytes(report.bytes));
}

}  // namespace

void addExport(CLI::App& app, Context& context) {
  auto a = std::make_shared<ExportArguments>();
  CLI::App* command =
      app.add_subcommand("export", "write a store as one OpenVDB file, for Blender, Houdini or ParaView");
  command->add_option("STORE", a->store, "the store")->required();
  command->add_option("OUT", a->output, "the .vdb to write")->required();
  addNumber(*command, "--level", a->level, "0 is finest")->capture_default_str();
  addMemory(*command, a->memory, "the grid, a brick and the index")->capture_default_str();
  command->add_flag("--overwrite", a->overwrite, "replace a file that is there");
  addExamples(*command, {"kiln export head.kiln head.vdb", "kiln export head.kiln head.vdb --overwrite"});
  command->callback([a, &context] { context.action = [a, &context] { run(*a, context); }; });
}

}  // namespace kiln::tool
