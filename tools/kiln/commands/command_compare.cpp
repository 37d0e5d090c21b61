#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/file/file.h"
#include "base/memory/memory.h"
#include "base/memory/spare_pages.h"
#include "commands.h"
#include "examples.h"
#include "image/compare.h"
#include "image/file/image_file.h"
#include "image/image_memory.h"
#include "output_files.h"
#include "say.h"
#include "source_arguments.h"
#include "store/manifest/json_text.h"

namespace kiln::tool {
namespace {

struct CompareArguments {
  std::string a, b, output, memory = kDefaultMemory;
  bool json = false;
};

void run(const CompareArguments& arguments) {
  boundSparePages(0);  // kept memory of earlier pictures is not counted
  if (!arguments.output.empty()) {
    requireImagePath(arguments.output);
    FileSystem::real().requirePlaceFor(arguments.output);
    OutputFiles outputs;
    outputs.add(arguments.output);
    for (const std::string& read : {arguments.a, arguments.b}) outputs.requireNone(read);
  }
  const std::uint64_t memory_bytes = parseBytes(arguments.memory, "--memory");
  for (const std::string& read : {arguments.a, arguments.b}) refuseVolumeFile(read, "a picture");
  const Image a = readImage(arguments.a, {}, memory_bytes);
  const std::uint64_t picture_bytes = a.rgba.size() * sizeof(float);
  const Image b = readImage(arguments.b, {}, memory_bytes - picture_bytes);
  if (a.width != b.width || a.height != b.height)
    throw Error(ErrorCode::kUsage, arguments.b, "",
                fmt::format("is {} x {} pixels, but {} is {} x {}", b.width, b.height, arguments.a, a.width, a.height));
  if (!arguments.output.empty()) requireMemory(3 * picture_bytes, memory_bytes, arguments.output);
  const ImageDifference d = compareImages(a, b);
  if (!arguments.output.empty()) writeImage(differenceImage(a, b), {}, {}, arguments.output);
  if (arguments.json) {
    const nlohmann::ordered_json out = {
        {"psnr_db", numberJson(d.psnr_db)},  {"foreground_psnr_db", numberJson(d.foreground_psnr_db)},
        {"largest", numberJson(d.largest)},  {"differing_pixels", d.differing},
        {"foreground_pixels", d.foreground}, {"mean_brightness_ratio", numberJson(d.mean_brightness_ratio)}};
    sayJson(out.dump(1) + "\n");
    return;
  }
  if (d.differing == 0) {
    say("equal colours: {} x {} pixels\n", a.width, a.height);
    return;
  }
  say("PSNR {:.2f} dB, {:.2f} dB over {} foreground pixels; largest difference {:.4g} of 1; {} pixels differ; mean "
      "brightness ratio {:.4f}\n",
      d.psnr_db, d.foreground_psnr_db, d.foreground, d.largest, d.differing, d.mean_brightness_ratio);
}

}  // namespace

void addCompare(CLI::App& app, Context& context) {
  auto a = std::make_shared<CompareArguments>();
  CLI::App* command =
      app.add_subcommand("compare", "Say how far the colours of two pictures are apart, of several views the first's.");
  command->add_option("A", a->a, "A picture, .exr or .png.")->required();
  command->add_option("B", a->b, "The other picture.")->required();
  command->add_option("-o,--output", a->output,
                      "The difference as a picture, in the colours of Lee and Ihm's Figure 11.");
  command->add_flag(
      "--json", a->json,
      "For programs. psnr_db, the first PSNR, counts alpha; foreground_psnr_db counts colours alone. Equal pictures "
      "have inf.");
  addMemory(*command, a->memory, "both pictures and their difference")->capture_default_str();
  addExamples(*command, {"kiln compare face.png mip.png", "kiln compare face.png mip.png -o difference.png --json"});
  command->callback([a, &context] { context.action = [a] { run(*a); }; });
}

}  // namespace kiln::tool
