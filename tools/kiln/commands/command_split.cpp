#include <fmt/format.h>

#include "base/memory/memory.h"
#include "commands.h"
#include "examples.h"
#include "job/frame_list.h"
#include "ranks/rank_boxes.h"
#include "ranks/split_store.h"
#include "say.h"
#include "scene/transfer/presets.h"
#include "scene/volume_part.h"
#include "scene_arguments.h"
#include "sequence/render_job_run.h"
#include "source_arguments.h"

namespace kiln::tool {
namespace {

struct SplitArguments {
  std::string store, output, tf = "auto", memory = kDefaultMemory;
  int parts = 0;
};

void run(const SplitArguments& a, Context& context) {
  if (!hasFramePlace(a.output))
    throw Error(ErrorCode::kUsage, a.output, "", "has no place for the parts' numbers; write a run of #");
  if (a.parts < 1 || a.parts > kMostParts)
    throw Error(ErrorCode::kUsage, fmt::format("--parts: expected 1 to {}, found {}", kMostParts, a.parts));
  refuseVolumeFile(a.store, "a store");
  const StoreReader store(a.store, parseBytes(a.memory, "--memory"));
  if (findStorePart(store.path(), context.progress))
    throw Error(ErrorCode::kUsage, a.store, "",
                "is a part that kiln split made, and lacks the bricks of others; split the whole store");
  PictureOptions picture;
  picture.transfer_function = transferFunctionNamed(a.tf, "--tf");
  const std::vector<VoxelBox> boxes = boxesForRanks(store, transferFunctionFor(picture, store), a.parts);
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    const std::filesystem::path path = pathOfFrame(a.output, static_cast<int>(i) + 1);
    const StorePart part = writeStorePart(store, boxes[i], path, context.progress);
    context.progress.clear();
    const VoxelBox& box = boxes[i];
    say("{}: voxels {},{},{} to {},{},{}, {}\n", path.string(), box.lo.x, box.lo.y, box.lo.z, box.hi.x, box.hi.y,
        box.hi.z, part.was_there ? "is there already" : formatBytes(part.bytes));
  }
}

}  // namespace

void addSplit(CLI::App& app, Context& context) {
  auto a = std::make_shared<SplitArguments>();
  CLI::App* command = app.add_subcommand(
      "split", "Cut a store into parts for the disks of many machines, for render --distribute bricks --store-local.");
  command->add_option("STORE", a->store, "The store.")->required();
  command
      ->add_option("-o,--output", a->output,
                   "The parts, in whose name a run of # is the part's number: 1 is the first rank's.")
      ->required();
  addNumber(*command, "--parts", a->parts, "Number of stores, one a rank.")->required()->type_name("N");
  CLI::Option* const function =
      command
          ->add_option("--tf", a->tf,
                       "The transfer function that is to be drawn: each part has an even share of what it shows.")
          ->capture_default_str();
  context.facts.offer(function, presetNames());
  addMemory(*command, a->memory, "the index")->capture_default_str();
  addExamples(*command, {"kiln split head.kiln -o node_##.kiln --parts 2",
                         "kiln split head.kiln -o bone_##.kiln --parts 2 --tf ct-bone"});
  command->callback([a, &context] { context.action = [a, &context] { run(*a, context); }; });
}

}  // namespace kiln::tool
