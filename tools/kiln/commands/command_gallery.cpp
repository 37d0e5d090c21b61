#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/file/file.h"
#include "base/memory/memory.h"
#include "base/process.h"
#include "base/shell_text.h"
#include "commands.h"
#include "examples.h"
#include "foreign_store.h"
#include "image/file/image_file.h"
#include "job/job_names.h"
#include "output_files.h"
#include "say.h"
#include "scene/transfer/presets.h"
#include "scene_arguments.h"
#include "sequence/sheet/gallery.h"
#include "source_arguments.h"
#include "store/store_reader.h"

namespace kiln::tool {
namespace {

struct GalleryArguments {
  std::string store, output, memory = kDefaultMemory, look{kLookNames.front()};
  GalleryRequest request;
  ForeignArguments source;
};

void requirePreset(const std::string& name) {
  if (!isPreset(name))
    throw Error(ErrorCode::kUsage,
                fmt::format("--tf: '{}' is no preset; there are {}{}", name, presetList(), presetHint(name)));
  transferFunctionNamed(name, "--tf");
}

void run(const GalleryArguments& a, Context& context) {
  for (const std::string& preset : a.request.presets) requirePreset(preset);
  requireImagePath(a.output);
  FileSystem::real().requirePlaceFor(a.output);
  OutputFiles outputs;
  outputs.add(a.output);
  a.source.requireNoneForStore(a.store);
  GalleryRequest request = a.request;
  request.look = static_cast<Look>(std::find(kLookNames.begin(), kLookNames.end(), a.look) - kLookNames.begin());
  request.speed.memory_bytes = parseBytes(a.memory, "--memory");
  request.store = storeOfInput(a.source.volume(a.store), request.speed.memory_bytes, outputs, context);
  const Gallery gallery = drawGallery(request, context.progress);
  writeImage(gallery.sheet, {}, ImageFileOptions().within(request.speed.memory_bytes, gallery.sheet), a.output);
  context.progress.clear();
  noteBlack(gallery.sheet, a.output, context.progress);
  for (const GalleryRow& row : gallery.rows)
    say("kiln render {} --tf {}{} -o {}.png\n", shellText(request.store.string()), row.preset, optionOf(request.look),
        row.preset);
  say("{}: {} x {} pixels, {} preset{} from {} sides; {} bricks read ({})\n", a.output, gallery.sheet.width,
      gallery.sheet.height, gallery.rows.size(), gallery.rows.size() == 1 ? "" : "s", galleryViews().size(),
      gallery.bricks_read, formatBytes(gallery.read_bytes));
}

}  // namespace

void addGallery(CLI::App& app, Context& context) {
  auto a = std::make_shared<GalleryArguments>();
  CLI::App* command = app.add_subcommand("gallery", "Draw a sheet of thumbnails: every preset from four sides.");
  command->add_option("STORE", a->store, "The store, or a volume file (converted to a store beside it first).")
      ->required();
  command->add_option("-o,--output", a->output, "The sheet, .png, .exr, .tif or .jpg.")->required();
  context.facts.offer(command->add_option("--tf", a->request.presets, "Draw these presets only.")->type_name("PRESET"),
                      presetNames());
  CLI::Option* const look = command->add_option("--look", a->look, "Light of the pictures, as for render.")
                                ->check(oneOf(kLookNames))
                                ->capture_default_str();
  context.facts.offer(look, {kLookNames.begin(), kLookNames.end()});
  command->add_option("--thumbnail", a->request.thumbnail_px, "Edge of a thumbnail.")
      ->type_name("PIXELS")
      ->check(wholeNumberFrom(32, 1024))
      ->capture_default_str();
  addMemory(*command, a->memory, "the sheet, the index and bricks")->capture_default_str();
  command->add_option("--threads", a->request.speed.threads, "Threads; 0 uses all processors.")
      ->check(wholeNumberFrom(0, kMostThreads))
      ->capture_default_str();
  addForeignArguments(*command, context.facts, a->source);
  addExamples(*command, {"kiln gallery head.kiln -o gallery.png", "kiln gallery head.kiln -o studio.png --look studio",
                         "kiln gallery head.kiln -o bones.png --tf ct-bone --tf ct-teeth --thumbnail 256"});
  command->callback([a, &context] { context.action = [a, &context] { run(*a, context); }; });
}

}  // namespace kiln::tool
