#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/byte_record.h"
#include "base/duration_text.h"
#include "base/memory/memory.h"
#include "base/thread/parallel.h"
#include "commands.h"
#include "convert/conversion_cost.h"
#include "convert/convert.h"
#include "convert/stream/half_source.h"
#include "examples.h"
#include "ingest/open_source.h"
#include "ingest/volume_list.h"
#include "say.h"
#include "scene/transfer/label_styles.h"
#include "source_arguments.h"
#include "store/manifest/json_text.h"
#include "store/manifest/read_manifest.h"
#include "store/store_reader.h"

namespace kiln::tool {
namespace {

struct ConvertArguments {
  std::string input, output, memory = kDefaultMemory;
  unsigned threads = 0;
  std::int64_t brick_size = kDefaultBrickSize;
  bool overwrite = false, resume = false, half = false, labels = false, dry_run = false, list = false, json = false;
  bool quiet = false;
  int levels = 0;
  SourceWords source;
};

std::string firstLine(const SourceInfo& info) {
  const Extent3& dims = info.geometry.dims;
  return fmt::format("{} x {} x {} voxels of {} ({}) from {}", dims.x, dims.y, dims.z, nameOf(info.type),
                     formatBytes(static_cast<std::uint64_t>(dims.count()) * sizeOf(info.type)), info.format);
}

std::string readingOf(const ConversionCost& cost) {
  if (cost.order == ReadOrder::kAnyBox) return "1 pass, in boxes of a brick with its apron";
  return fmt::format("1 pass, in order, through a window of {} slices {}", cost.plan.window_slices,
                     cost.plan.window_on_disk ? "in a scratch file" : "in memory");
}

std::string timesText(double times) {
  const std::string number = fmt::format("{:.3g}", times);
  return number == "1" ? "once" : number + " times";
}

std::string decodingOf(const ConversionPlan& plan, const Extent3& shape) {
  return fmt::format("each block of {} x {} x {} {}{}", shape.x, shape.y, shape.z, plan.decodings > 1 ? "up to " : "",
                     timesText(plan.decodings)) +
         (plan.decodings > 1 ? "; once with --memory " + roundedUpBytes(plan.once_bytes) : "");
}

void printCost(const ConvertArguments& a, VolumeSource& source, const ConvertOptions& options, Context& context) {
  const ConversionCost cost = conversionCost(source, options, context.progress);
  context.progress.clear();
  say("{}: {}\n", a.input, firstLine(source.info()));
  say("reading      {}\n", readingOf(cost));
  if (const auto blocks = source.decodedBlocks()) say("decoding     {}\n", decodingOf(cost.plan, blocks->shape));
  say("memory       up to {} in buffers, of {} allowed; {} thread{}\n", formatBytes(cost.plan.total()),
      formatBytes(options.memory_bytes), cost.plan.lanes, cost.plan.lanes == 1 ? "" : "s");
  const std::string bricks = fmt::format("{} brick{} of {} level{}", cost.bricks, cost.bricks == 1 ? "" : "s",
                                         cost.levels, cost.levels == 1 ? "" : "s");
  const std::string samples = cost.sampled_slices > 0 ? fmt::format("{} bricks of the first {} slices",
                                                                    cost.sampled_bricks, cost.sampled_slices)
                                                      : fmt::format("{} of them", cost.sampled_bricks);
  say("writing      about {} in {}, as {} say that were read and encoded\n", formatBytes(cost.store_bytes), bricks,
      samples);
  const std::uint64_t scratch = cost.plan.scratch_bytes;
  say("scratch      {}\n", scratch > 0 ? fmt::format("up to {} beside it until it is finished", formatBytes(scratch))
                                       : std::string("none: what waits is in memory"));
  if (options.ranks->count() > 1)
    say("ranks        {}, each with that memory{}\n", options.ranks->count(),
        cost.order == ReadOrder::kForward ? "; each reads all of the input, which comes in one order only" : "");
  say("time         about {}, by those bricks: {:.3g} million voxels/s\n", durationText(cost.seconds),
      static_cast<double>(source.info().geometry.dims.count()) / 1e6 / cost.seconds);
  say("nothing was written\n");
}

// Returns the largest loss of all ranks, on the first rank.
HalfLoss lossOfAll(HalfLoss loss, Ranks& ranks) {
  std::vector<std::byte> bytes;
  appendValue(bytes, loss);
  for (const std::vector<std::byte>& of_rank : ranks.gather(bytes)) loss.include(ByteTaker{of_rank}.take<HalfLoss>());
  return loss;
}

void printRanks(const ConvertReport& report) {
  for (std::size_t i = 0; i < report.ranks.size(); ++i) {
    const RankConversion& rank = report.ranks[i];
    const double all_s = rank.busy_s + rank.idle_s;
    say("rank {}: {} bricks, {} read, {} written, {} sent to others; {} thread{} busy {:.0f} % of the time\n", i,
        rank.bricks, formatBytes(rank.read_bytes), formatBytes(rank.written_bytes), formatBytes(rank.sent_bytes),
        rank.lanes, rank.lanes == 1 ? "" : "s", all_s > 0 ? 100 * rank.busy_s / all_s : 0.0);
  }
}

void printReport(const ConvertArguments& a, const SourceInfo& info, const ConvertReport& report) {
  say("{}: {}\n", a.output, firstLine(info));
  // The rate counts the bricks that this run of a resumed conversion made.
  const double rate = static_cast<double>(report.voxels) / 1e6 / report.seconds;
  const std::string work = report.voxels > 0
                               ? fmt::format("{}, {:.1f} million voxels/s, buffers up to {}",
                                             durationText(report.seconds), rate, formatBytes(report.buffer_bytes))
                               : "nothing was left to do";
  say("{} of {} bricks stored, {} on disk; {}{}\n", report.stored_bricks, report.bricks,
      formatBytes(report.stored_bytes), work,
      report.decodings > 0 ? ", each block decoded " + timesText(report.decodings) : "");
  if (report.ranks.size() > 1) printRanks(report);
}

// Pictures draw labels up to kLargestLabel; a store may hold more, for export and statistics.
void warnOfLabels(const std::string& store, Context& context) {
  const ValueRange range = readManifest(store).range;
  if (areDistinct(range)) return;
  const std::string beyond =
      range.hi > kLargestLabel
          ? fmt::format("above {:.0f} cannot be drawn (largest found: {:.0f})", kLargestLabel, range.hi)
          : fmt::format("below {:.0f} cannot be drawn (smallest found: {:.0f})", -kLargestLabel, range.lo);
  context.progress.warn(
      fmt::format("{}: labels {}, and kiln render refuses the store; number the labels anew", store, beyond));
}

std::string sizeText(const ListedVolume& volume) {
  const std::string type =
      volume.type ? fmt::format(" of {} ({})", nameOf(*volume.type), formatBytes(volume.bytes())) : "";
  if (!volume.dims) return "size unknown before it is read";
  return fmt::format("{} x {} x {}{}", volume.dims->x, volume.dims->y, volume.dims->z, type);
}

std::string listForPrograms(const std::string& input, const std::vector<ListedVolume>& volumes) {
  using Json = nlohmann::ordered_json;
  Json list = Json::array();
  for (const ListedVolume& volume : volumes) {
    const auto& dims = volume.dims;
    list.push_back({{"name", volume.name},
                    {"kind", volume.kind},
                    {"dimensions", dims ? Json({dims->x, dims->y, dims->z}) : Json(nullptr)},
                    {"type", volume.type ? Json(nameOf(*volume.type)) : Json(nullptr)},
                    {"rawBytes", volume.bytes()},
                    {"option", volume.option},
                    {"refusal", volume.refusal}});
  }
  return jsonText(Json({{"input", utf8OfName(input)}, {"volumes", list}}), 1) + "\n";
}

void list(const ConvertArguments& a, Context& context) {
  if (!context.ranks->first()) return;
  SourceOptions options = a.source.resolve();
  options.memory_bytes = parseBytes(a.memory, "--memory");
  const std::vector<ListedVolume> volumes = volumesIn(a.input, options);
  if (a.json) return sayJson(listForPrograms(a.input, volumes));
  say("{}: {} {}\n", a.input, volumes.size(), volumes.size() == 1 ? "volume" : "volumes");
  std::size_t name_width = 0, kind_width = 0, size_width = 0;
  for (const ListedVolume& volume : volumes) {
    name_width = std::max(name_width, volume.name.size());
    kind_width = std::max(kind_width, volume.kind.size());
    size_width = std::max(size_width, sizeText(volume).size());
  }
  for (const ListedVolume& volume : volumes) {
    const std::string line =
        fmt::format("  {:<{}}  {:<{}}  {:<{}}  {}", volume.name, name_width, volume.kind, kind_width, sizeText(volume),
                    size_width, volume.refusal.empty() ? volume.option : "not read: " + volume.refusal);
    say("{}\n", line.substr(0, line.find_last_not_of(' ') + 1));
  }
}

void run(const ConvertArguments& a, Context& context) {
  // A folder of slices may hold a file of that name, too.
  if (std::error_code ignored; isStore(a.input) && std::filesystem::exists(a.input + "/index.bin", ignored))
    throw Error(ErrorCode::kUsage, a.input, "",
                "is a store already: kiln render draws it, kiln export makes a file of another format of it");
  if (a.list) return list(a, context);
  if (a.output.empty() && !a.dry_run) throw Error(ErrorCode::kUsage, "OUT: name the store to write, NAME.kiln");
  if (a.quiet) context.progress.silence();
  keepFreedMemory();
  const ThreadLimit threads(a.threads);
  SourceOptions source_options = a.source.resolve();
  source_options.memory_bytes = parseBytes(a.memory, "--memory");
  std::unique_ptr<VolumeSource> source = openSource(a.input, source_options);
  const HalfSource* rounded = nullptr;
  if (a.half) {
    auto half = std::make_unique<HalfSource>(std::move(source));
    rounded = half.get();
    source = std::move(half);
  }
  ConvertOptions options;
  options.brick_size = a.brick_size;
  options.memory_bytes = source_options.memory_bytes;
  options.overwrite = a.overwrite;
  options.resume = a.resume;
  options.half = a.half;
  options.labels = a.labels;
  if (a.levels > 0) options.most_levels = a.levels;
  options.command = context.command_line;
  options.time = timeNow();
  options.ranks = context.ranks;
  const bool speaks = context.ranks->first();
  if (a.dry_run) {
    if (!speaks) return;
    for (const std::string& note : source->info().notes) context.progress.note(namedNote(source->info(), note));
    printCost(a, *source, options, context);
    return;
  }
  const ConvertReport report = convert(*source, a.output, options, context.progress);
  const HalfLoss loss = rounded != nullptr ? lossOfAll(rounded->loss(), *context.ranks) : HalfLoss();
  context.progress.clear();
  if (!speaks) return;
  if (!a.quiet) {
    printReport(a, source->info(), report);
    if (rounded != nullptr)
      say("rounded to half: no value changed by more than {:g}, no mean of a coarser level by more than {:g}\n",
          loss.largest_error, loss.largest_error + report.half_error);
    if (report.nan_count > 0) say("{} voxels are NaN and will be transparent\n", report.nan_count);
  }
  if (const std::string lost = loss.warning(); !lost.empty()) context.progress.warn(a.output + ": " + lost);
  if (makesLabels(source->info(), options)) warnOfLabels(a.output, context);
}

}  // namespace

void addConvert(CLI::App& app, Context& context) {
  auto a = std::make_shared<ConvertArguments>();
  CLI::App* command =
      app.add_subcommand("convert",
                         "Convert a volume (raw, NRRD, MetaImage, NIfTI, MRC, MGH, AmiraMesh, VGI, VTK, NumPy, TIFF, "
                         "DICOM, OpenVDB, Zarr, N5, HDF5) to a brick store.");
  command
      ->add_option("INPUT", a->input,
                   "The volume to read: a file, a directory of slices (TIFF, DICOM, PNG, JPEG, JPEG 2000), a DICOMDIR, "
                   "or a computed one: "
                   "phantom:body:XxYxZ, head, brain or engine.")
      ->required();
  command->add_option("OUT", a->output, "The store to write, by custom NAME.kiln.");
  addMemory(*command, a->memory, "buffers; under mpirun of each rank")->capture_default_str();
  command->add_option("--threads", a->threads, "Threads; 0 takes all.")
      ->check(wholeNumberFrom(0, kMostThreads))
      ->capture_default_str();
  addNumber(*command, "--brick-size", a->brick_size, "Voxels along a brick's edge, a power of two.")
      ->capture_default_str();
  command
      ->add_option("--levels", a->levels, "The most levels of resolution; as many as it takes to one brick by default.")
      ->check(wholeNumberFrom(1));
  command->add_flag("--half", a->half,
                    "Round values to 16-bit floats: smaller bricks of 32-bit floats; the largest error is printed.");
  command
      ->add_flag("--labels", a->labels,
                 "Values are labels, whole numbers: a coarser voxel is the most frequent of those below it (of equally "
                 "frequent ones the smallest that is not 0), and pictures have a colour for each.")
      ->excludes("--half");
  command->add_flag("--dry-run", a->dry_run,
                    "Write nothing; say how it would be read, what memory, disk and time it takes.");
  CLI::Option* const list =
      command->add_flag("--list", a->list,
                        "Convert nothing; list the volumes in the file or folder, their sizes, and the option that "
                        "chooses each.");
  command->add_flag("--json", a->json, "Print the list for programs.")->needs(list);
  auto* overwrite =
      command->add_flag("--overwrite", a->overwrite, "Replace a store that is there, once the new one is whole.");
  command
      ->add_flag("--resume", a->resume,
                 "Go on with an interrupted conversion of the same input with the same options, or begin.")
      ->excludes(overwrite);
  addQuiet(*command, a->quiet);
  addRankTimeout(*command, context);
  addSourceArguments(*command, context.facts, a->source);
  addExamples(*command, {"kiln convert phantom:head:64x64x64 head.kiln", "kiln convert scan.nrrd scan.kiln --memory 1G",
                         "kiln convert rock.raw rock.kiln --dims 16,16,8 --type u16 --spacing 0.02,0.02,0.02"});
  command->callback([a, &context] {
    context.by_all_ranks = true;
    context.action = [a, &context] { run(*a, context); };
  });
}

}  // namespace kiln::tool
