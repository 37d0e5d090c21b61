#include <fmt/format.h>

#include <set>
#include <utility>

#include "base/file/file.h"
#include "base/file/file_lock.h"
#include "base/file/folder.h"
#include "base/find_program.h"
#include "base/memory/memory.h"
#include "cluster/shared_lists.h"
#include "commands.h"
#include "examples.h"
#include "foreign_store.h"
#include "frame/empty_frame.h"
#include "image/file/image_file.h"
#include "input_job.h"
#include "job/command/idle_flags.h"
#include "job/frame_list.h"
#include "job/job_facts.h"
#include "job/job_names.h"
#include "job_arguments.h"
#include "output_files.h"
#include "picture_job.h"
#include "say.h"
#include "scene/transfer/presets.h"
#include "scene/volume_part.h"
#include "scene_arguments.h"
#include "sequence/dry_run.h"
#include "sequence/frame_checkpoint.h"
#include "sequence/frame_files.h"
#include "sequence/render_job_run.h"
#include "sequence/sequence.h"
#include "sequence/sequence_frames.h"
#include "sequence/series_volumes.h"
#include "sequence/sheet/sequence_sheet.h"
#include "sequence_report.h"
#include "standard_output.h"
#include "store/manifest/read_manifest.h"
#include "store/store_reader.h"

namespace kiln::tool {
namespace fs = std::filesystem;
namespace {

constexpr int kMostRepeats = 1'000'000;

struct RenderArguments {
  std::string input, stats, progress = "auto";
  std::optional<std::string> store_local, share;
  bool quiet = false, verbose = false, strict = false, dry_run = false, resume = false, checkpoint = false;
  int repeat = 1, sheet = 0;
  JobArguments job;
  AddedArguments volumes;
  ForeignArguments source;
};

void findEncoder(const RenderArguments& a, RenderJob& job) {
  VideoOptions& video = job.output.video;
  if (a.job.given().has("--rate") && video.path.empty())
    throw Error(ErrorCode::kUsage, "--rate: no video is made; name one, such as -o turn.mp4");
  if (video.path.empty()) return;
  if (framesOf(job).size() == 1 && !a.job.given().has("--frames"))
    throw Error(
        ErrorCode::kUsage, video.path, "",
        "a video needs frames (found 1); add --turntable 120, give a job with frames, or name a picture, .exr or "
        ".png");
  if (a.dry_run) return;
  video.encoder = findProgram("ffmpeg");
  if (video.encoder.empty())
    throw Error(
        ErrorCode::kNotFound, video.path, "",
        "a video needs the program ffmpeg, which is in no absolute folder of PATH; install it (Debian: apt-get install "
        "ffmpeg), or write pictures");
}

void requireOutput(const RenderArguments& a, const OutputOptions& output) {
  if (output.path.empty() && output.files.empty() && output.video.path.empty() && !a.dry_run)
    throw Error(ErrorCode::kUsage, "-o: name the picture to write, such as .exr or .png, or a video, .mp4 or .webm");
}

// Leaves every N-th of the job's frames, from the I-th on.
void applyShare(const std::string& text, RenderJob& job) {
  const std::optional<PartNumber> share = partNumbered(text);
  if (!share)
    throw Error(ErrorCode::kUsage, fmt::format("--share: expected I/N, I from 1 to N (found '{}'); write 1/4", text));
  const std::vector<int> all = framesOf(job);
  job.frames.clear();
  for (std::size_t i = static_cast<std::size_t>(share->index - 1); i < all.size();
       i += static_cast<std::size_t>(share->count))
    job.frames.push_back(all[i]);
  if (job.frames.empty())
    throw Error(ErrorCode::kUsage,
                fmt::format("--share {}: the job has fewer frames (found {}); give a smaller N", text, all.size()));
  if (!job.output.video.path.empty() && share->count > 1)
    throw Error(ErrorCode::kUsage, job.output.video.path, "--share",
                "a video needs all frames (found a share); write pictures, frame_####.png, and make the video of them");
}

// Leaves out planes of the job that an output of the command line cannot hold, as in a preview.
void dropPlanes(const RenderArguments& a, RenderJob& job, Context& context) {
  const fs::path& path = job.output.path;
  const bool replaced = a.sheet > 0 || a.job.given().has("--output");
  const bool holds_planes = a.sheet == 0 && (path.empty() || isExrPath(path));
  if (!job.picture.aovs.any() || holds_planes || !replaced || a.job.given().has("--aov")) return;
  job.picture.aovs = {};
  if (context.ranks->first())
    context.progress.note(fmt::format("{}: holds colours alone; the planes of image.aov are left out", path.string()));
}

// Leaves the frames of a sheet.
void applySheet(const RenderArguments& a, RenderJob& job) {
  if (a.resume || a.checkpoint || a.repeat > 1 || !a.stats.empty())
    throw Error(ErrorCode::kUsage,
                "--sheet: a sheet is drawn at once; leave --resume, --checkpoint, --repeat and --stats out");
  job.frames = framesOfSheet(job, a.sheet);
  if (!a.job.given().has("--size") && isVolumeName(a.input)) job.picture.size = kSheetFrameSize;
  requireSheet(job);
}

// Returns the temporary files beside the pictures: locks and checkpoints.
std::vector<fs::path> passingFiles(const RenderArguments& a, const RenderJob& job) {
  std::vector<fs::path> out;
  if (const fs::path& video = job.output.video.path; !video.empty()) out.push_back(lockOf(behindLinks(video)));
  if (!a.checkpoint) return out;
  for (const int frame : framesOf(job)) {
    if (filesOf(job, frame).empty()) continue;
    out.push_back(checkpointOf(job, frame));
    out.push_back(lockOf(out.back()));
  }
  return out;
}

// Returns all files that the command writes.
OutputFiles outputsOf(const RenderArguments& a, const RenderJob& job) {
  OutputFiles out;
  out.add(a.stats, "--stats");
  out.add(job.trace, "--trace");
  for (const fs::path& path : namesOf(job.output)) out.add(path);
  for (const int frame : framesOf(job)) {
    for (const OutputFile& file : filesOf(job, frame)) out.add(file.path);
  }
  for (const fs::path& path : passingFiles(a, job)) out.add(path);
  return out;
}

// Checks that no output is an input. The files of a foreign volume are checked later, when the volume is open
// (SequenceOptions::store_for).
void requireInputsApart(const RenderArguments& a, const RenderJob& job) {
  const OutputFiles outputs = outputsOf(a, job);
  std::vector<fs::path> inputs = inputsOf(job);
  inputs.insert(inputs.begin(), a.input);
  std::error_code ignored;
  for (const fs::path& input : inputs) {
    if (isStore(input) || !fs::is_directory(input, ignored)) outputs.requireNone(input);
  }
}

// Returns true if `path` is the folder or lies in it. Neither has to exist.
bool isIn(const fs::path& path, const fs::path& folder) {
  std::error_code unknown;
  const auto whole_name = [&](const fs::path& name) {
    fs::path out = fs::absolute(name, unknown);
    if (!unknown) out = fs::weakly_canonical(out, unknown);
    if (unknown) throw systemError(unknown.value(), name, "looking at its folder");
    return out;
  };
  return isWithin(whole_name(behindLinks(path)), whole_name(folder));
}

// Checks that no output lies in the folder of a video's frames, because the folder is removed at the end.
void requireOutsideKeptFrames(const RenderJob& job, const fs::path& path, const char* option) {
  if (!keepsFramesForVideo(job) || path.empty() || !isIn(path, keptFramesOf(job.output.video))) return;
  throw Error(ErrorCode::kUsage,
              fmt::format("{}: {} is in {}, where the frames of the video are kept until it is made; name another file",
                          option, path.string(), keptFramesOf(job.output.video).string()));
}

// Checks that statistics and trace do not overwrite another output of the command.
void requireOwnFiles(const RenderArguments& a, const RenderJob& job) {
  requireInputsApart(a, job);
  for (const fs::path& path : namesOf(job.output)) requireOutsideKeptFrames(job, path, "-o");
  if (a.stats.empty() && job.trace.empty()) return;
  FileNames taken;
  for (const fs::path& path : namesOf(job.output)) taken.add(path);
  for (const int frame : framesOf(job)) {
    for (const OutputFile& file : filesOf(job, frame)) taken.add(file.path);
  }
  for (const fs::path& path : passingFiles(a, job)) taken.add(path);
  for (const auto& [option, name] : {std::pair{"--stats", fs::path(a.stats)}, std::pair{"--trace", job.trace}}) {
    if (name.empty()) continue;
    if (isStandardOutputName(name))
      throw Error(ErrorCode::kUsage, fmt::format("{}: standard output takes a picture alone (found {}); name a file",
                                                 option, name.string()));
    requireOutsideKeptFrames(job, name, option);
    if (!taken.add(name))
      throw Error(ErrorCode::kUsage,
                  fmt::format("{}: {} is the name of another file of this command", option, name.string()));
  }
}

// Checks that standard output gets one whole picture.
void requireOnePicture(const RenderArguments& a, const RenderJob& job, const Context& context) {
  if (a.resume || a.checkpoint)
    throw Error(ErrorCode::kUsage,
                "-o -: standard output keeps nothing to go on from; leave --resume and --checkpoint out");
  if (!context.ranks->alone())
    throw Error(ErrorCode::kUsage, "-o -: is one process's standard output (found several ranks); name a file");
  if (const std::size_t frames = framesOf(job).size(); frames > 1 && a.sheet == 0)
    throw Error(ErrorCode::kUsage,
                fmt::format("-o -: standard output takes one picture (found {} frames); add --frames 1, or name files",
                            frames));
}

RenderJob jobOf(const RenderArguments& a, StandardOutput& standard_output, Context& context) {
  RenderJob job = jobOfInput(a.input, a.job.given(), a.volumes);
  if (isStandardOutputName(job.output.path)) requireOnePicture(a, job, context);
  dropPlanes(a, job, context);
  standard_output.take(job.output);
  requireOutput(a, job.output);
  if (a.share) applyShare(*a.share, job);
  findEncoder(a, job);
  requirePart(job);
  requireVolumes(job);
  requireViews(job);
  if (a.job.given().hasAny({"--deep-samples", "--deep-error"}) && !drawsDeep(job))
    throw Error(ErrorCode::kUsage, "--deep-samples, --deep-error: no deep image is drawn; add --deep");
  if (a.sheet > 0)
    applySheet(a, job);
  else
    requireOutputs(job, framesOf(job));
  requireOwnFiles(a, job);
  return job;
}

void requireNoWarnings(std::uint64_t warnings) {
  if (warnings > 0)
    throw Error(ErrorCode::kIo,
                fmt::format("--strict: all is done, but {}",
                            warnings == 1 ? "there was a warning" : fmt::format("there were {} warnings", warnings)));
}

void requireStatisticsPlace(const RenderArguments& a) {
  if (!a.stats.empty()) FileSystem::real().requirePlaceFor(a.stats);
}

// Prints the cost of the render. throws: Error kBudget if the memory is too small.
void sayCost(const RenderArguments& a, RenderJob job, const InputOptions& input, const MemoryBeside& beside,
             TerminalProgress& progress) {
  requireStatisticsPlace(a);
  const int first = framesOf(job).front();
  const bool series = isSeries(job);
  const OutputFiles outputs = outputsOf(a, job);
  forEachVolume(job, [&](const fs::path& volume) {
    const fs::path of_first = series ? pathOfFrame(volume, first) : volume;
    const auto opened = [&](const SourceInfo& info) { outputs.requireNoneOf(info.files); };
    const fs::path store = madeStoreFor(input.of(of_first), job.speed.memory_bytes, input.areLabels(volume), opened);
    outputs.requireNone(store);
    return store == of_first ? volume : store;
  });
  const DryRun cost = dryRun(job, beside);
  if (!a.stats.empty()) FileSystem::real().writeAtomic(a.stats, dryRunText(cost));
  if (const std::vector<int> frames = framesOf(job); frames.size() > 1)
    say("frames       {}; bricks and disk are of the first, {}\n", frames.size(), frames.front());
  say("bricks       {}; {} hold something the transfer function shows, {} of these are in view\n", cost.bricks_total,
      cost.bricks_interesting, cost.bricks_in_view);
  const FrameMemory& memory = cost.memory;
  say("disk         a frame reads at most {} files, {}{}; it does not read what is hidden behind opaque parts\n",
      cost.files_in_view, formatBytes(cost.file_bytes_in_view),
      memory.band > 0 ? ", once for each band of samples that finds them no longer in memory" : "");
  if (cost.bricks_of_lights > 0)
    say("             shadows and ambient occlusion read at most {} files of {} bricks, {}, before the frame\n",
        cost.files_of_lights, cost.bricks_of_lights, formatBytes(cost.file_bytes_of_lights));
  const PixelRect drawn = drawnPixels(job.picture.size, job.picture.crop);
  say("memory       {} of image ({} x {} pixels{}), ", formatBytes(memory.image), drawn.width(), drawn.height(),
      cost.samples > 1 ? fmt::format(" of {} samples", cost.samples) : "");
  if (memory.band > 0) say("{} of a band of its samples, ", formatBytes(memory.band));
  if (memory.face > 0) say("{} of a face that it is made of, ", formatBytes(memory.face));
  if (memory.deep > 0) say("{} of deep samples, ", formatBytes(memory.deep));
  if (memory.shadows > 0) say("{} of shadows and ambient occlusion, ", formatBytes(memory.shadows));
  if (memory.files > 0) say("{} to compress files, ", formatBytes(memory.files));
  if (memory.functions > 0) say("{} of transfer functions, ", formatBytes(memory.functions));
  say("{} of visibility, {} of index, {} to draw with, {} of threads' stacks, {}{} {}\n",
      formatBytes(memory.visibility), formatBytes(memory.index), formatBytes(memory.slabs), formatBytes(memory.threads),
      memory.trace > 0 ? formatBytes(memory.trace) + " of the trace, " : "", formatBytes(memory.brick),
      memory.brickText());
  say("             --memory {} is the smallest that works, with {} to draw with\n", roundedUpBytes(memory.smallest()),
      formatBytes(memory.least_slabs));
  const std::uint64_t left = cacheBytes(memory, cost.budget_bytes, job.volume);
  say("             --memory {} leaves {} for bricks; all in view take {} once they are read\n",
      a.job.given().text("--memory").value_or(roundedUpBytes(cost.budget_bytes)), formatBytes(left),
      formatBytes(cost.decoded_bytes_in_view));
  std::set<std::string> doubted;
  warnOf(cost.doubts, doubted, progress);
  if (cost.empty != EmptyFrame::kShows)
    progress.warn(fmt::format("the picture is empty: {}", emptyText(cost.empty)));
  else if (cost.one_colour)
    progress.warn(fmt::format("the picture is of one colour: {}", kOneColourText));
  if (a.strict) requireNoWarnings(progress.warnings());
}

std::string countedFrames(const std::vector<int>& frames) {
  return fmt::format("{} frame{} ({})", frames.size(), frames.size() == 1 ? "" : "s", framesText(frames));
}

// Collective. The warnings of all ranks, on the first.
std::uint64_t warningsOfAll(Ranks& ranks, const TerminalProgress& progress) {
  std::uint64_t out = 0;
  for (const std::uint64_t of_rank : gatherLists(ranks, std::vector<std::uint64_t>{progress.warnings()}))
    out += of_rank;
  return out;
}

ReportKind reportKind(const RenderArguments& a) {
  if (a.progress == "json") return ReportKind::kEvents;
  return a.quiet ? ReportKind::kQuiet : a.verbose ? ReportKind::kVerbose : ReportKind::kBrief;
}

void runFrames(const RenderArguments& a, const RenderJob& job, const SequenceOptions& options, Context& context) {
  SequenceReport report(context.progress, reportKind(a));
  try {
    if (context.ranks->first()) requireStatisticsPlace(a);
    const SequenceResult result = runSequence(job, options, context.progress, report);
    const std::uint64_t warnings = warningsOfAll(*context.ranks, context.progress);
    if (!context.ranks->first()) return;
    if (!a.stats.empty()) FileSystem::real().writeAtomic(a.stats, statisticsText(result.statistics));
    report.finished(job, result);
    const std::vector<int>& failed = result.statistics.failed;
    if (!failed.empty())
      throw Error(ErrorCode::kIo,
                  fmt::format("{} failed; the first: {}; {}the same command with --resume draws what is missing",
                              countedFrames(failed), result.first_failure,
                              failed.size() < framesOf(job).size() ? "the others are there, and " : ""));
    if (a.strict) requireNoWarnings(warnings);
  } catch (const Error& error) {
    report.ended(error);
    throw;
  }
}

void repeatFrame(const RenderArguments& a, RenderJob job, const SequenceOptions& options, Context& context) {
  if (const std::size_t frames = framesOf(job).size(); frames > 1 || a.resume || !job.output.video.path.empty())
    throw Error(ErrorCode::kUsage, "--repeat measures one frame: it is not for several frames, --resume or a video");
  requireStatisticsPlace(a);
  const int frame = framesOf(job).front();
  job.series = seriesLook(job, options.store_for);
  job = jobAtFrame(job, frame);
  forEachVolume(job, options.store_for);
  job.frames = {frame};
  const RenderStatistics statistics = runRenderJob(job, a.repeat, context.progress).statistics;
  if (!a.stats.empty()) FileSystem::real().writeAtomic(a.stats, statisticsText(statistics));
  SequenceReport(context.progress, reportKind(a)).frameDone(job, statistics.frames.back(), 1);
  if (a.strict) requireNoWarnings(context.progress.warnings());
}

void drawSheet(const RenderArguments& a, const RenderJob& job, const SequenceOptions& options, Context& context) {
  FileSystem::real().requirePlaceFor(job.output.path);
  const Image sheet = drawSequenceSheet(job, options.store_for, context.progress);
  const ImageFileOptions file{.exr_float = job.output.exr_float,
                              .png_bits = job.output.png_bits,
                              .exr_compression = job.output.exr_compression,
                              .jpeg_quality = job.output.jpeg_quality};
  writeImage(sheet, {}, file.within(job.speed.memory_bytes, sheet), job.output.path);
  context.progress.clear();
  noteBlack(sheet, job.output.path, context.progress);
  if (!a.quiet)
    say("{}: {} x {} pixels, {}\n", job.output.path.string(), sheet.width, sheet.height, countedFrames(framesOf(job)));
  if (a.strict) requireNoWarnings(context.progress.warnings());
}

void applyProgress(const std::string& kind, TerminalProgress& progress) {
  if (kind == "json" || kind == "none")
    progress.silence();
  else if (kind == "plain")
    progress.plain();
  else if (kind != "auto")
    throw Error(ErrorCode::kUsage, fmt::format("--progress: expected auto, plain, json or none, found '{}'", kind));
}

void run(const RenderArguments& a, Context& context) {
  applyProgress(a.quiet && a.progress == "auto" ? "none" : a.progress, context.progress);
  shareHeaps();
  StandardOutput standard_output;
  const RenderJob job = jobOf(a, standard_output, context);
  keepFreedBuffers(job.speed.memory_bytes);
  if (context.ranks->first()) {
    for (const std::string& sentence : idleFlags(a.job.given(), job)) context.progress.warn(sentence);
  }
  if (!context.ranks->first() && (a.dry_run || a.repeat > 1 || a.sheet > 0)) return;
  SequenceOptions options;
  options.ranks = context.ranks;
  options.store_local = a.store_local.value_or("");
  if (a.store_local && (job.distribution != Distribution::kBricks || context.ranks->alone()))
    throw Error(ErrorCode::kUsage, "--store-local: is for --distribute bricks, under mpirun with several ranks");
  options.resume = a.resume;
  options.checkpoint = a.checkpoint;
  if (a.checkpoint && (a.repeat > 1 || !context.ranks->alone()))
    throw Error(ErrorCode::kUsage,
                "--checkpoint keeps the tiles of one process, drawn once: not with --repeat or mpirun");
  if (a.progress == "json" && (a.dry_run || a.repeat > 1 || a.sheet > 0))
    throw Error(
        ErrorCode::kUsage,
        "--progress json: tells of frames that become files, not of --dry-run, --repeat and --sheet; --stats has their "
        "numbers");
  if (a.checkpoint) requireCheckpoint(job);
  const InputOptions input(a.source, job);
  if (a.dry_run) return sayCost(a, job, input, besideBytes(job, options), context.progress);
  const OutputFiles outputs = outputsOf(a, job);
  options.store_for = [&](const fs::path& volume) {
    const bool labels = input.areLabels(volume);
    return requiredClass(storeOfInput(input.of(volume), job.speed.memory_bytes, outputs, context, labels), labels);
  };
  if (a.repeat > 1)
    repeatFrame(a, job, options, context);
  else if (a.sheet > 0)
    drawSheet(a, job, options, context);
  else
    runFrames(a, job, options, context);
  standard_output.copy();
}

// Adds the job's file to an error of the job's camera, unless an option changed the camera.
Error inJob(const RenderArguments& a, const Error& error) {
  const std::string text = error.what();
  const bool of_camera = error.path().empty() && text.find("camera: ") != std::string::npos;
  const bool changed =
      a.job.given().hasAny({"--projection", "--view", "--eye", "--target", "--up", "--azimuth", "--elevation"});
  if (!of_camera || changed || extensionOf(a.input) != ".json") return error;
  return Error(error.code(), a.input, "", text);
}

// The options of the command itself and, by group, the options of jobs.
class RenderCommandLine {
 public:
  RenderCommandLine(CLI::App& command, RenderArguments& a, Context& context) : command_(command), a_(a) {
    command
        .add_option("INPUT", a.input,
                    "A store, a volume file (converted to a store beside it first), JOB.json, or a picture of Kiln, "
                    ".exr or .png, "
                    "whose job is drawn.")
        ->required();
    for (std::size_t i = 0; i < kOptionGroupNames.size(); ++i) {
      group_ = static_cast<OptionGroup>(i);
      a.job.addTo(command, context.facts, group_);
      if (group_ == OptionGroup::kShown) a.volumes.addTo(command, context.facts);
      if (group_ == OptionGroup::kCost) addCost(context);
      if (group_ == OptionGroup::kFrames) addFrames();
      if (group_ == OptionGroup::kRanks) addRanks(context);
    }
    addForeignArguments(command, context.facts, a.source);
  }

 private:
  void flag(const char* name, bool& value, const char* help) {
    command_.add_flag(name, value, help)->group(nameOf(group_));
  }
  template <class T>
  CLI::Option* option(const char* name, const char* type, T& value, const char* help) {
    return command_.add_option(name, value, help)->type_name(type)->group(nameOf(group_));
  }

  void addCost(Context& context) {
    flag("--dry-run", a_.dry_run, "Print the bricks, the disk reads and the memory of the job; draw nothing.");
    option("--stats", "FILE", a_.stats, "Write counts and times of the rendering as JSON.");
    option("--repeat", "N", a_.repeat, "Draw the frame this many times; from the second on bricks are in memory.")
        ->check(wholeNumberFrom(1, kMostRepeats))
        ->capture_default_str();
    flag("--strict", a_.strict,
         "Exit with 1 after a warning: an empty picture or one colour, damaged bricks, an unknown frame or unit, an "
         "option without effect.");
    command_.add_flag("--quiet", a_.quiet, "Print notes, warnings and errors only.")
        ->group(nameOf(group_))
        ->excludes(command_.add_flag("--verbose", a_.verbose, "Print counts of bricks and voxels of each frame.")
                       ->group(nameOf(group_)));
    context.facts.offer(
        option(
            "--progress", "auto|plain|json|none", a_.progress,
            "Progress of frames and job: auto (default) rewrites a line of a terminal, plain prints a line every ten "
            "seconds, json prints events to standard output."),
        {"auto", "plain", "json", "none"});
  }
  void addFrames() {
    option("--share", "I/N", a_.share,
           "Draw every N-th of the frames, from the I-th on: the share of one of N machines without MPI.");
    option("--sheet", "N", a_.sheet,
           "Draw N frames at equal steps into one picture, -o, each with its number, and no frame into a file. A frame "
           "has 256x256 pixels without --size.")
        ->check(wholeNumberFrom(2, kMostSheetFrames));
    flag("--resume", a_.resume, "Keep frames that exist and are whole; draw the others.");
    flag("--checkpoint", a_.checkpoint,
         "Draw a long frame in tiles of 512x512 pixels, and keep finished tiles in NAME.tiles until the picture is "
         "written. --resume continues from them.");
  }
  void addRanks(Context& context) {
    addRankTimeout(command_, context)->group(nameOf(group_));
    option("--store-local", "DIR", a_.store_local,
           "With --distribute bricks: directory of each rank's part of the store, made by kiln split. A run of # "
           "becomes the rank's number, from 1 on.");
  }

  CLI::App& command_;
  RenderArguments& a_;
  OptionGroup group_ = OptionGroup::kOutput;
};

}  // namespace

void addRender(CLI::App& app, Context& context) {
  auto a = std::make_shared<RenderArguments>();
  CLI::App* command = app.add_subcommand("render", "Draw a picture of a store, a volume file or a job.");
  RenderCommandLine(*command, *a, context);
  addExamples(*command,
              {"kiln render head.kiln -o face.png --tf ct-skin --view front --size 512x512",
               "kiln render head.kiln -o mip.png --mode mip --window 1100,2000 --size 512x512",
               "kiln render head.kiln -o turn.png --tf ct-bone --turntable 120 --sheet 12",
               "kiln render head.kiln -o frame_####.png --tf ct-bone --turntable 12 --size 256x256 --resume"});
  command->callback([a, &context] {
    context.by_all_ranks = true;
    context.action = [a, &context] {
      try {
        run(*a, context);
      } catch (const Error& error) {
        throw inJob(*a, error);
      }
    };
  });
}

}  // namespace kiln::tool
