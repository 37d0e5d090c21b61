#include <fmt/format.h>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "base/memory/memory.h"
#include "base/thread/parallel.h"
#include "commands.h"
#include "examples.h"
#include "ranks/split_store.h"
#include "say.h"
#include "source_arguments.h"
#include "store/verify.h"

namespace kiln::tool {
namespace {

struct VerifyArguments {
  std::string store, memory = kDefaultMemory;
  unsigned threads = 0;
};

void run(const VerifyArguments& a, Context& context) {
  const ThreadLimit threads(a.threads);
  refuseVolumeFile(a.store, "a store");
  const std::uint64_t memory_bytes = parseBytes(a.memory, "--memory");
  const StoreReader store(a.store, memory_bytes);
  std::function<bool(const BrickKey&)> holds;
  if (const std::optional<VoxelBox> part = findStorePart(store.path(), context.progress))
    holds = bricksOfStorePart(store, *part);
  const VerifyReport report = verify(
      store, memory_bytes, [&](const Error& damage) { context.progress.note(damage.what()); }, context.progress, holds);
  context.progress.clear();
  if (report.damaged > 0)
    throw Error(ErrorCode::kDamaged, store.path(), "",
                fmt::format("{} of {} files damaged", report.damaged, report.files));
  say("{}: {}, {} files checked\n", a.store, holds ? "has all of its part" : "whole", report.files);
}

}  // namespace

void addVerify(CLI::App& app, Context& context) {
  auto a = std::make_shared<VerifyArguments>();
  CLI::App* command = app.add_subcommand(
      "verify", "Check every file of a store against its checksum, and every octree against its voxels.");
  command->add_option("STORE", a->store, "The store.")->required();
  addMemory(*command, a->memory, "bricks and the index")->capture_default_str();
  command->add_option("--threads", a->threads, "Threads; 0 takes all.")
      ->check(wholeNumberFrom(0, kMostThreads))
      ->capture_default_str();
  addExamples(*command, {"kiln verify head.kiln", "kiln verify head.kiln --threads 2 --memory 500M"});
  command->callback([a, &context] { context.action = [a, &context] { run(*a, context); }; });
}

}  // namespace kiln::tool
