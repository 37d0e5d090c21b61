#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "base/file/file.h"
#include "base/file/folder.h"
#include "base/memory/memory.h"
#include "base/memory/spare_pages.h"
#include "commands.h"
#include "composite/composite_parts.h"
#include "examples.h"
#include "frame/background.h"
#include "job/job_names.h"
#include "output_files.h"
#include "say.h"
#include "source_arguments.h"

namespace kiln::tool {
namespace {

struct CompositeArguments {
  std::vector<std::string> parts;
  std::string output, exr_type = "half", exr_compression = "zip", memory = kDefaultMemory;
  int png_bits = 8;
};

void run(const CompositeArguments& a, Context& context) {
  boundSparePages(0);  // kept memory of earlier pictures is not counted
  requireImagePath(a.output);
  FileSystem::real().requirePlaceFor(a.output);
  OutputFiles outputs;
  outputs.add(a.output);
  for (const std::string& part : a.parts) outputs.requireNone(part);
  for (const std::string& part : a.parts) refuseVolumeFile(part, "a partial image");
  const std::uint64_t memory_bytes = parseBytes(a.memory, "--memory");
  CompositedParts made =
      compositeParts({a.parts.begin(), a.parts.end()}, context.progress, memory_bytes, mediumOf(a.output));
  if (const auto folder = made.drawn_from.empty() ? std::nullopt : folderSeenFrom(a.output, made.drawn_from))
    made.metadata.text[ImageMetadata::kFolder] = *folder;
  writeImage(
      made.image, made.metadata,
      {a.exr_type == "float", a.png_bits, a.exr_compression, memory_bytes - std::min(memory_bytes, made.image.bytes())},
      a.output);
  context.progress.clear();
  noteBlack(made.image, a.output, context.progress);
  if (made.volume_share < 1)
    context.progress.warn(fmt::format("the parts hold {:.2f} % of the volume; the rest is missing from the picture",
                                      100 * made.volume_share));
  say("{}: {} x {} pixels from {} part{}\n", a.output, made.image.width, made.image.height, a.parts.size(),
      a.parts.size() == 1 ? "" : "s");
}

}  // namespace

void addComposite(CLI::App& app, Context& context) {
  auto a = std::make_shared<CompositeArguments>();
  CLI::App* command =
      app.add_subcommand("composite", "Put partial images of a volume, drawn with render --part, together.");
  command->add_option("PARTS", a->parts, "The partial images, in any order.")->required();
  command->add_option("-o,--output", a->output, "The whole picture, such as .exr or .png.")->required();
  CLI::Option* const type =
      command->add_option("--exr-type", a->exr_type, "Numbers of an EXR: half (default) or float.")
          ->check(CLI::IsMember({"half", "float"}));
  context.facts.offer(type, {"half", "float"});
  CLI::Option* const compression = command
                                       ->add_option("--compression", a->exr_compression,
                                                    fmt::format("Compression of an EXR: {}; zip if not given.",
                                                                fmt::join(kExrCompressionNames, ", ")))
                                       ->check(oneOf(kExrCompressionNames));
  context.facts.offer(compression, {kExrCompressionNames.begin(), kExrCompressionNames.end()});
  addMemory(*command, a->memory, "the picture and a part")->capture_default_str();
  CLI::Option* const bits =
      addNumber(*command, "--png-bits", a->png_bits, "Bits of a channel of a PNG: 8 (default) or 16.")
          ->check(CLI::IsMember({8, 16}));
  context.facts.offer(bits, {"8", "16"});
  addExamples(*command,
              {"kiln render head.kiln -o part1.exr --part 1/2", "kiln render head.kiln -o part2.exr --part 2/2",
               "kiln composite part1.exr part2.exr -o head.exr"});
  command->callback([a, &context] { context.action = [a, &context] { run(*a, context); }; });
}

}  // namespace kiln::tool
