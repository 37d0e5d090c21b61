#include <fmt/format.h>

#include <algorithm>

#include "base/memory/memory.h"
#include "commands.h"
#include "frame/slice.h"
#include "image/file/image_file.h"
#include "output_files.h"
#include "say.h"
#include "scene_arguments.h"
#include "source_arguments.h"

namespace kiln::tool {
namespace {

struct SliceArguments {
  std::string store, output, axis = "z", window, memory = kDefaultMemory;
  int level = 0;
  std::optional<std::int64_t> index;
};

void warnBeside(const std::string& picture, const Window& window, const ValueRange& range, Progress& progress) {
  if (range.hi >= window.centre - 0.5 * window.width && range.lo <= window.centre + 0.5 * window.width) return;
  progress.warn(
      fmt::format("{}: the picture is of one colour: all values of the volume, {:g} to {:g}, lie beside --window",
                  picture, range.lo, range.hi));
}

void run(const SliceArguments& a, Context& context) {
  requireImagePath(a.output);
  FileSystem::real().requirePlaceFor(a.output);
  OutputFiles outputs;
  outputs.add(a.output);
  outputs.requireNone(a.store);
  SliceRequest request;
  const std::string axes = "xyz";
  if (a.axis.size() != 1 || axes.find(a.axis) == std::string::npos)
    throw Error(ErrorCode::kUsage, fmt::format("--axis: expected x, y or z, found '{}'", a.axis));
  request.axis = static_cast<int>(axes.find(a.axis));
  request.level = a.level;
  request.index = a.index;
  request.memory_bytes = parseBytes(a.memory, "--memory");
  if (!a.window.empty()) request.window = parseWindow(a.window, "--window");
  refuseVolumeFile(a.store, "a store");
  const StoreReader store(a.store, request.memory_bytes);
  const Image image = renderSlice(store, request, context.progress);
  ImageFileOptions file;
  file.writer_bytes = request.memory_bytes - std::min(request.memory_bytes, image.bytes() + store.index().bytes());
  writeImage(image, {}, file, a.output);
  if (request.window && !store.manifest().range.empty())
    warnBeside(a.output, *request.window, store.manifest().range, context.progress);
  context.progress.clear();
  say("{}: {} x {} pixels\n", a.output, image.width, image.height);
}

}  // namespace

void addSlice(CLI::App& app, Context& context) {
  auto a = std::make_shared<SliceArguments>();
  CLI::App* command = app.add_subcommand("slice", "draw one slice, the first look after converting");
  command->add_option("STORE", a->store, "the store")->required();
  command->add_option("-o,--output", a->output, "the picture, .png or .exr")->required();
  command->add_option("--axis", a->axis, "x, y or z")->capture_default_str();
  addNumber(*command, "--level", a->level, "0 is finest")->capture_default_str();
  addNumber(*command, "--index", a->index, "the slice, in voxels of the level; the middle one if not given");
  command->add_option("--window", a->window, "values shown: the middle 99 % if not given")->type_name("CENTRE,WIDTH");
  addMemory(*command, a->memory, "the picture, a brick and the index")->capture_default_str();
  command->callback([a, &context] { context.action = [a, &context] { run(*a, context); }; });
}

}  // namespace kiln::tool
