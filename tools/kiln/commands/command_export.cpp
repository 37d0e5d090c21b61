#include <fmt/format.h>

#include <limits>

#include "base/file/file.h"
#include "base/memory/memory.h"
#include "base/thread/parallel.h"
#include "commands.h"
#include "examples.h"
#include "export/export_store.h"
#include "job/option_kinds.h"
#include "job/transfer_function_choice.h"
#include "output_files.h"
#include "say.h"
#include "scene/transfer/presets.h"
#include "scene_arguments.h"
#include "source_arguments.h"

namespace kiln::tool {
namespace {

constexpr int kMostTiles = 10000;

struct ExportArguments {
  std::string store, memory = kDefaultMemory;
  unsigned threads = 0;
  std::optional<std::string> region, type, tf;
  ExportRequest request;
  bool quiet = false;
};

void run(const ExportArguments& a, Context& context) {
  if (a.quiet) context.progress.silence();
  const ThreadLimit threads(a.threads);
  ExportRequest request = a.request;
  if (a.type) request.values.type = *a.type == "half" ? VdbType::kHalf : VdbType::kFloat;
  requireExportFormat(request);
  if (a.region) request.region = valueOfFlag<std::optional<VoxelBox>>(VoxelBounds(), *a.region, "--region");
  OutputFiles outputs;
  outputs.add(request.out, "OUT");
  outputs.requireNone(a.store);
  refuseVolumeFile(a.store, "a store");
  request.memory_bytes = parseBytes(a.memory, "--memory");
  const StoreReader store(a.store, request.memory_bytes);
  store.requireLevel(request.level);
  if (a.tf) request.baked = resolve(transferFunctionNamed(*a.tf, "--tf"), std::nullopt, store.manifest());
  const ExportReport report = exportStore(store, request, context.progress);
  context.progress.clear();
  if (a.quiet) return;
  say("{}: {}, {}\n", request.out.string(), report.contents, formatBytes(report.bytes));
  for (const std::string& line : report.lines) say("{}\n", line);
}

}  // namespace

void addExport(CLI::App& app, Context& context) {
  auto a = std::make_shared<ExportArguments>();
  CLI::App* command = app.add_subcommand("export", "Write a store, or a part of it, as a file of another format.");
  command->add_option("STORE", a->store, "The store.")->required();
  command->add_option("OUT", a->request.out, "The file to write, by its ending: " + exportEndings() + ".")->required();
  addNumber(*command, "--level", a->request.level, "Level of resolution, 0 for the finest.")->capture_default_str();
  command->add_option("--region", a->region, "Write this box of voxels of level 0 only; X0 is inside, X1 outside.")
      ->type_name("X0,Y0,Z0,X1,Y1,Z1");
  command->add_flag("--compress", a->request.compress,
                    "Compress the voxels of a .nrrd by gzip, the grid of a .nvdb by zlib.");
  addNumber(*command, "--tiles", a->request.tiles,
            ".vdb, .nvdb: files side by side, each within the memory; the name has a # for the tile's number")
      ->check(wholeNumberFrom(1, kMostTiles))
      ->capture_default_str();
  CLI::Option* const type =
      command->add_option("--type", a->type, ".vdb: numbers of the grid; those of the store if not given.")
          ->type_name("float|half")
          ->check(CLI::IsMember({"float", "half"}));
  context.facts.offer(type, {"float", "half"});
  CLI::Option* const function =
      command
          ->add_option(
              "--tf", a->tf,
              ".vdb, .nvdb: bake a transfer function into the grids density and Cd; a preset or a file, as for render.")
          ->type_name("NAME");
  context.facts.offer(function, presetNames());
  addNumber(*command, "--background", a->request.values.background,
            ".vdb, .nvdb: value of inactive space; the store's background if not given");
  addNumber(*command, "--tolerance", a->request.values.tolerance,
            ".vdb, .nvdb: values that differ from the background by so much become background")
      ->check(numberFrom(0, std::numeric_limits<double>::max()));
  addMemory(*command, a->memory, "a box of voxels, a brick for each thread and the index; the grid of a .vdb or .nvdb")
      ->capture_default_str();
  command->add_option("--threads", a->threads, "Threads; 0 takes all.")
      ->check(wholeNumberFrom(0, kMostThreads))
      ->capture_default_str();
  command->add_flag("--resume", a->request.resume, "Continue an interrupted export to .zarr or of --tiles.");
  command->add_flag("--overwrite", a->request.overwrite, "Replace files that are there.");
  addQuiet(*command, a->quiet);
  addExamples(*command,
              {"kiln export head.kiln head.nrrd", "kiln export head.kiln head.nii.gz",
               "kiln export head.kiln head.ome.zarr", "kiln export head.kiln part.mhd --region 0,0,0,32,32,32",
               "kiln export head.kiln head.vdb --overwrite", "kiln export head.kiln tile_#.vdb --tiles 4 --type half"});
  command->callback([a, &context] { context.action = [a, &context] { run(*a, context); }; });
}

}  // namespace kiln::tool
