#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <set>
#include <utility>

#include "base/file.h"
#include "base/file_lock.h"
#include "base/folder.h"
#include "base/memory/memory.h"
#include "cluster/shared_lists.h"
#include "commands.h"
#include "convert/foreign_cache.h"
#include "find_program.h"
#include "frame/empty_frame.h"
#include "job/frame_list.h"
#include "job/job_names.h"
#include "output_files.h"
#include "say.h"
#include "scene/transfer/presets.h"
#include "scene_arguments.h"
#include "sequence/dry_run.h"
#include "sequence/frame_checkpoint.h"
#include "sequence/frame_files.h"
#include "sequence/render_job_run.h"
#include "sequence/sequence.h"
#include "sequence/sequence_frames.h"
#include "sequence/series_volumes.h"
#include "sequence_report.h"
#include "source_arguments.h"
#include "store/manifest/read_manifest.h"
#include "store/store_reader.h"

namespace kiln::tool {
namespace fs = std::filesystem;
namespace {

struct RenderArguments {
  std::string input, output, stats, trace, progress = "auto";
  std::optional<std::string> size, crop, mode, projection, eye, target, up, view, tf, visibility, area, lattice,
      interpolation, level, samples, memory, exr_type, compression, owner, comments, part, stereo, window;
  std::optional<double> interocular, convergence, fov, height, azimuth, elevation, zoom, threshold, sample_distance;
  std::optional<unsigned> threads;
  std::optional<int> png_bits, epsilon, tile, deep_samples;
  std::vector<std::string> aovs, added, added_tfs, labels;
  std::optional<std::string> distribute, share_reads, store_local;
  std::optional<std::string> frames;
  std::optional<int> turntable;
  std::optional<std::string> rate;
  std::optional<double> deep_error;
  bool strict = false, nodes_only = false, skip_damaged = false, dry_run = false, exr_statistics = false,
       resume = false, checkpoint = false, deep = false;
  int repeat = 1;
  SceneArguments scene;
  SourceArguments source;
};

// The enumerator that has this name.
template <class E, std::size_t N>
E named(const std::array<std::string_view, N>& names, const std::string& found, const char* option) {
  const auto it = std::find(names.begin(), names.end(), found);
  if (it == names.end())
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: expected one of {}, found '{}'", option, fmt::join(names, ", "), found));
  return static_cast<E>(it - names.begin());
}

constexpr std::array<std::string_view, 2> kOffOn = {"off", "on"};

// Numbers a job would refuse, refused the same way on the command line.
double between(double value, double lo, double hi, const char* option) {
  if (!(value > lo && value <= hi))
    throw Error(ErrorCode::kUsage, fmt::format("{}: {} is not above {} and at most {}", option, value, lo, hi));
  return value;
}

void applyCamera(const RenderArguments& a, CameraSpec& camera) {
  if (a.projection) camera.projection = named<Projection>(kProjectionNames, *a.projection, "--projection");
  if (a.view) camera.side = named<Side>(kSideNames, *a.view, "--view");
  if (a.eye) camera.eye = parseTriple(*a.eye, "--eye");
  if (a.target) camera.target = parseTriple(*a.target, "--target");
  if (a.up) camera.up = parseTriple(*a.up, "--up");
  if (a.fov) camera.fov_deg = a.fov;
  if (a.height) camera.height = a.height;
  if (a.azimuth) camera.azimuth_deg = a.azimuth;
  if (a.elevation) camera.elevation_deg = a.elevation;
  if (a.zoom) camera.zoom = a.zoom;
}

// None for "auto". throws: Error kUsage where it is neither that nor a number that `legal` takes.
std::optional<int> numberOrAuto(const std::string& text, const char* option, const char* expected, bool legal(int)) {
  if (text == "auto") return std::nullopt;
  int number = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size() || !legal(number))
    throw Error(ErrorCode::kUsage, fmt::format("{}: expected auto{}, found '{}'", option, expected, text));
  return number;
}

void applyStereo(const RenderArguments& a, std::optional<Stereo>& stereo) {
  if (!a.stereo && !a.interocular && !a.convergence) return;
  constexpr double kLongest = 1e30;
  if (!stereo && !a.stereo)
    throw Error(ErrorCode::kUsage, "--interocular, --convergence: no pair is drawn; add --stereo both, left or right");
  if (!stereo) stereo = Stereo{};
  if (a.stereo) stereo->eye = named<StereoEye>(kStereoEyeNames, *a.stereo, "--stereo");
  if (a.interocular) stereo->interocular = between(*a.interocular, 0, kLongest, "--interocular");
  if (a.convergence) stereo->convergence = between(*a.convergence, 0, kLongest, "--convergence");
  if (!(stereo->interocular > 0))
    throw Error(ErrorCode::kUsage, "--stereo: how far the eyes are apart, --interocular, is missing");
}

void applyPart(const std::string& text, PictureOptions& picture) {
  picture.clipping.part.reset();
  picture.part = partNumbered(text);
  if (!picture.part) picture.clipping.part = parseVoxelBox(text, "--part", "I/N, I from 1 to N, or x0,y0,z0,x1,y1,z1");
}

void applyPicture(const RenderArguments& a, PictureOptions& picture) {
  if (a.size) {
    const auto [width, height] = parseSize(*a.size, "--size");
    picture.size = {width, height};
  }
  if (a.crop) picture.crop = parseCrop(*a.crop, "--crop");
  if (a.projection == kProjectionNames[2] && !a.size && extensionOf(a.input) != ".json") picture.size = kPanoramaSize;
  drawnPixels(picture.size, picture.crop);
  if (a.samples) picture.samples = numberOrAuto(*a.samples, "--samples", ", 1, 2, 4 or 16", samplesKnown);
  if (!a.aovs.empty()) picture.aovs = {};
  for (const std::string& name : a.aovs) picture.aovs.of(named<Aov>(kAovNames, name, "--aov")) = true;
  applyCamera(a, picture.camera);
  applyStereo(a, picture.stereo);
  a.scene.apply(picture);
  if (a.tf) {
    picture.transfer_function = transferFunctionNamed(*a.tf, "--tf");
  }
  if (a.window) picture.window = parseWindow(*a.window, "--window");
  if (a.threshold) picture.opacity_threshold = between(*a.threshold, 0, 1, "--opacity-threshold");
  if (a.lattice)
    picture.lattice = latticeOfName(static_cast<std::size_t>(named<int>(kLatticeNames, *a.lattice, "--lattice")));
  if (a.interpolation)
    picture.interpolation = named<Interpolation>(kInterpolationNames, *a.interpolation, "--interpolation");
  if (a.mode) picture.mode = named<Mode>(kModeNames, *a.mode, "--mode");
  if (a.sample_distance) picture.sample_distance = *a.sample_distance;
  requireEngineOptions(picture);
  if (a.part) applyPart(*a.part, picture);
  if (a.skip_damaged) picture.skip_damaged = true;
  if (a.level) {
    picture.level = numberOrAuto(*a.level, "--level", " or a number from 0 on", [](int level) { return level >= 0; });
  }
}

void applySpeed(const RenderArguments& a, SpeedOptions& speed) {
  if (a.visibility) speed.visibility.method = named<VisibilityMethod>(kVisibilityNames, *a.visibility, "--visibility");
  if (a.area) speed.visibility.area = named<ProjectedArea>(kProjectedAreaNames, *a.area, "--projected-area");
  if (a.epsilon)
    speed.visibility.epsilon_px = static_cast<int>(between(*a.epsilon, -1, kLargestEpsilon, "--quadtree-epsilon"));
  if (a.nodes_only) speed.visibility.test_samples = false;
  if (a.tile) speed.tile_px = *a.tile;
  if (a.memory) speed.memory_bytes = parseBytes(*a.memory, "--memory");
  if (a.threads) speed.threads = *a.threads;
}

void requireStillCamera(const RenderArguments& a, const RenderJob& job) {
  const bool keys = std::holds_alternative<CameraKeyframes>(job.animation.camera);
  const bool matrices = std::holds_alternative<CameraMatrices>(job.animation.camera);
  if ((!keys && !matrices) || a.turntable) return;
  const std::pair<const char*, bool> given[] = {
      {"--eye", a.eye.has_value()},   {"--target", a.target.has_value()},   {"--up", a.up.has_value()},
      {"--view", a.view.has_value()}, {"--azimuth", a.azimuth.has_value()}, {"--elevation", a.elevation.has_value()},
      {"--zoom", a.zoom.has_value()}, {"--fov", keys && a.fov.has_value()}, {"--height", keys && a.height.has_value()}};
  for (const auto& [option, is_given] : given) {
    if (is_given)
      throw Error(ErrorCode::kUsage, fmt::format("{}: the job says by {} where the camera is in each frame; change it "
                                                 "there, or give --turntable",
                                                 option, keys ? "keyframes" : "matrices"));
  }
}

// Values of options replace the job's keyframes.
void applyFrames(const RenderArguments& a, RenderJob& job) {
  requireStillCamera(a, job);
  if (a.frames) job.frames = parseFrames(*a.frames, "--frames");
  if (a.turntable) {
    if (*a.turntable < 1 || static_cast<std::size_t>(*a.turntable) > kMostFrames)
      throw Error(ErrorCode::kUsage,
                  fmt::format("--turntable: expected 1 to {} frames, found {}", kMostFrames, *a.turntable));
    job.animation.camera = Turntable{*a.turntable, 360, std::nullopt};
  }
  if (a.tf) job.animation.functions.clear();
  if (a.interocular || a.convergence) job.animation.stereo.clear();
  if (!a.scene.lights.empty()) job.animation.lights.clear();
  if (!a.scene.planes.empty()) job.animation.clip.clear();
}

void applyVideo(const RenderArguments& a, VideoOptions& video) {
  if (a.rate && video.path.empty())
    throw Error(ErrorCode::kUsage, "--rate: no video is made; name one, such as -o turn.mp4");
  if (a.rate) {
    const std::optional<FrameRate> rate = frameRateFrom(*a.rate);
    if (!rate) throw Error(ErrorCode::kUsage, fmt::format("--rate: expected {}, found '{}'", kFrameRateForms, *a.rate));
    video.rate = *rate;
  }
  if (video.path.empty() || a.dry_run) return;
  video.encoder = findProgram("ffmpeg");
  if (video.encoder.empty())
    throw Error(
        ErrorCode::kNotFound, video.path, "",
        "a video needs the program ffmpeg, which is in no absolute folder of PATH; install it (Debian: apt-get install "
        "ffmpeg), or write pictures");
}

void applyDeep(const RenderArguments& a, OutputOptions& output) {
  if (a.deep) output.deep = true;
  if (a.deep_samples)
    output.deep_bound.samples =
        static_cast<int>(between(*a.deep_samples, 0, DeepBound::kMostSamples, "--deep-samples"));
  if (a.deep_error && (!(*a.deep_error >= 0) || *a.deep_error > 1))
    throw Error(ErrorCode::kUsage, fmt::format("--deep-error: expected a number from 0 to 1, found {}", *a.deep_error));
  if (a.deep_error) output.deep_bound.error = static_cast<float>(*a.deep_error);
}

void applyOutput(const RenderArguments& a, OutputOptions& output) {
  if (!a.output.empty()) {
    output.path.clear();
    output.video.path.clear();
    output.files.clear();
    putOutput(a.output, output);
  }
  if (output.path.empty() && output.files.empty() && output.video.path.empty() && !a.dry_run)
    throw Error(ErrorCode::kUsage, "-o: name the picture to write, .exr or .png, or a video, .mp4 or .webm");
  applyVideo(a, output.video);
  if (a.exr_type) {
    if (*a.exr_type != "half" && *a.exr_type != "float")
      throw Error(ErrorCode::kUsage, fmt::format("--exr-type: expected half or float, found '{}'", *a.exr_type));
    output.exr_float = *a.exr_type == "float";
  }
  if (a.compression) {
    named<int>(kExrCompressionNames, *a.compression, "--compression");
    output.exr_compression = *a.compression;
  }
  if (a.owner) output.owner = *a.owner;
  if (a.comments) output.comments = *a.comments;
  if (a.exr_statistics) output.statistics_in_header = true;
  applyDeep(a, output);
  if (a.png_bits) {
    if (*a.png_bits != 8 && *a.png_bits != 16)
      throw Error(ErrorCode::kUsage, fmt::format("--png-bits: expected 8 or 16, found {}", *a.png_bits));
    output.png_bits = *a.png_bits;
  }
}

// More volumes beside the job's; what other options say of a volume is of the first.
void applyVolumes(const RenderArguments& a, RenderJob& job) {
  const std::size_t more = a.added.size() + a.labels.size();
  if (a.added_tfs.size() > more)
    throw Error(ErrorCode::kUsage,
                fmt::format("--add-tf: {} given for {} volumes of --add and --labels; the first is of the first",
                            a.added_tfs.size(), more));
  if (job.volumes.empty() && more == 0) return;
  if (job.volumes.empty()) makeFirstOfSeveral(job);
  VolumeOptions& first = job.volumes.front();
  if (a.tf) {
    first.transfer_function = job.picture.transfer_function;
    first.functions.clear();
  }
  if (a.window) first.window = job.picture.window;
  if (auto region = std::exchange(job.picture.clipping.region, std::nullopt)) first.clipping.region = region;
  for (std::size_t i = 0; i < more; ++i) {
    VolumeOptions volume;
    volume.labels = i >= a.added.size();
    volume.volume = volume.labels ? a.labels[i - a.added.size()] : a.added[i];
    if (i < a.added_tfs.size()) volume.transfer_function = transferFunctionNamed(a.added_tfs[i], "--add-tf");
    job.volumes.push_back(std::move(volume));
  }
}

// Files that the command makes beside its pictures until these are whole.
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

// All files that the command writes.
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

void requireNone(const OutputFiles& outputs, const TransferFunctionChoice& read) {
  if (const auto* const file = std::get_if<fs::path>(&read)) outputs.requireNone(fileOf(*file));
}

// Tests that no output is a file that the command reads. The files of a foreign volume are known once it is opened
// (SequenceOptions::store_for).
void requireInputsApart(const RenderArguments& a, const RenderJob& job) {
  const OutputFiles outputs = outputsOf(a, job);
  const auto requireApart = [&](const TransferFunctionChoice& still,
                                const std::vector<Key<TransferFunctionChoice>>& keys) {
    requireNone(outputs, still);
    for (const Key<TransferFunctionChoice>& key : keys) requireNone(outputs, key.value);
  };
  std::error_code ignored;
  if (!fs::is_directory(a.input, ignored)) outputs.requireNone(a.input);
  requireApart(job.picture.transfer_function, job.animation.functions);
  for (const VolumeOptions& volume : job.volumes) requireApart(volume.transfer_function, volume.functions);
  std::set<fs::path> volumes;
  for (const fs::path& volume : volumesOf(job)) {
    volumes.insert(volume);
    for (const int frame : framesOf(job)) volumes.insert(pathOfFrame(volume, frame));
  }
  for (const fs::path& volume : volumes) {
    if (isStore(volume) || !fs::is_directory(volume, ignored)) outputs.requireNone(volume);
  }
}

// True for the folder itself, too; neither needs to be there.
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

// Tests that no output lies in the folder of a video's frames, which is removed with its content.
void requireOutsideKeptFrames(const RenderJob& job, const fs::path& path, const char* option) {
  if (!keepsFramesForVideo(job) || path.empty() || !isIn(path, keptFramesOf(job.output.video))) return;
  throw Error(ErrorCode::kUsage,
              fmt::format("{}: {} is in {}, where the frames of the video are kept until it is made; name another file",
                          option, path.string(), keptFramesOf(job.output.video).string()));
}

// Tests that statistics and trace do not overwrite another output of the command.
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
    requireOutsideKeptFrames(job, name, option);
    if (!taken.add(name))
      throw Error(ErrorCode::kUsage,
                  fmt::format("{}: {} is the name of another file of this command", option, name.string()));
  }
}

RenderJob jobOf(const RenderArguments& a) {
  RenderJob job;
  if (extensionOf(a.input) == ".json") {
    job = readJob(a.input);
  } else {
    job.volume = a.input;
  }
  applyPicture(a, job.picture);
  applySpeed(a, job.speed);
  applyFrames(a, job);
  applyVolumes(a, job);
  applyOutput(a, job.output);
  if (!a.trace.empty()) job.trace = a.trace;
  if (a.distribute) job.distribution = named<Distribution>(kDistributionNames, *a.distribute, "--distribute");
  if (a.share_reads) job.share_reads = named<int>(kOffOn, *a.share_reads, "--share-reads") == 1;
  requirePart(job);
  requireVolumes(job);
  requireViews(job);
  if ((a.deep_samples || a.deep_error) && !drawsDeep(job))
    throw Error(ErrorCode::kUsage, "--deep-samples, --deep-error: no deep image is drawn; add --deep");
  requireOutputs(job, framesOf(job));
  requireOwnFiles(a, job);
  return job;
}

// Options on how a foreign file is read are INPUT's, not those of volumes beside it; which volumes hold labels.
class InputOptions {
 public:
  InputOptions(const RenderArguments& a, const RenderJob& job) : options_(a.source.resolve()) {
    const fs::path input = job.volumes.empty() ? job.volume : job.volumes.front().volume;
    names_ = namesIn(job, input);
    for (const VolumeOptions& volume : job.volumes) {
      if (volume.labels) labels_.merge(namesIn(job, volume.volume));
    }
  }
  SourceOptions of(const fs::path& volume) const { return names_.contains(volume) ? options_ : SourceOptions(); }
  bool areLabels(const fs::path& volume) const { return labels_.contains(volume); }

 private:
  // The names of a volume in all frames; also of the first frame on the disk, which decides how a series looks.
  static std::set<fs::path> namesIn(const RenderJob& job, const fs::path& pattern) {
    std::set<fs::path> out = {pattern};
    for (const int frame : framesOf(job)) out.insert(pathOfFrame(pattern, frame));
    if (const std::vector<int> there = framesOnDisk(pattern); !there.empty())
      out.insert(pathOfFrame(pattern, there.front()));
    return out;
  }

  SourceOptions options_;
  std::set<fs::path> names_, labels_;
};

void requireNoWarnings(std::uint64_t warnings) {
  if (warnings > 0)
    throw Error(ErrorCode::kIo,
                fmt::format("--strict: all is done, but {}",
                            warnings == 1 ? "there was a warning" : fmt::format("there were {} warnings", warnings)));
}

void requireStatisticsPlace(const RenderArguments& a) {
  if (!a.stats.empty()) FileSystem::real().requirePlaceFor(a.stats);
}

// Says what the render would cost, and fails where the memory given is too little.
void sayCost(const RenderArguments& a, RenderJob job, const InputOptions& input, const MemoryBeside& beside,
             TerminalProgress& progress) {
  requireStatisticsPlace(a);
  const int first = framesOf(job).front();
  const bool series = isSeries(job);
  const OutputFiles outputs = outputsOf(a, job);
  forEachVolume(job, [&](const fs::path& volume) {
    const fs::path of_first = series ? pathOfFrame(volume, first) : volume;
    const auto opened = [&](const SourceInfo& info) { outputs.requireNoneOf(info.files); };
    const fs::path store = madeStoreFor(of_first, input.of(of_first), job.speed.memory_bytes, opened);
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
  const PixelRect drawn = drawnPixels(job.picture.size, job.picture.crop);
  say("memory       {} of image ({} x {} pixels{}), ", formatBytes(memory.image), drawn.width(), drawn.height(),
      cost.samples > 1 ? fmt::format(" of {} samples", cost.samples) : "");
  if (memory.band > 0) say("{} of a band of its samples, ", formatBytes(memory.band));
  if (memory.face > 0) say("{} of a face that it is made of, ", formatBytes(memory.face));
  if (memory.deep > 0) say("{} of deep samples, ", formatBytes(memory.deep));
  if (memory.files > 0) say("{} to compress files, ", formatBytes(memory.files));
  say("{} of visibility, {} of index, {} to draw with, {} of threads' stacks, {}{} {}\n",
      formatBytes(memory.visibility), formatBytes(memory.index), formatBytes(memory.slabs), formatBytes(memory.threads),
      memory.trace > 0 ? formatBytes(memory.trace) + " of the trace, " : "", formatBytes(memory.brick),
      memory.brickText());
  say("             --memory {} is the smallest that works, with {} to draw with\n", roundedUpBytes(memory.smallest()),
      formatBytes(memory.least_slabs));
  const std::uint64_t left = cacheBytes(memory, cost.budget_bytes, job.volume);
  say("             --memory {} leaves {} for bricks; all in view take {} once they are read\n",
      a.memory.value_or(roundedUpBytes(cost.budget_bytes)), formatBytes(left), formatBytes(cost.decoded_bytes_in_view));
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

void runFrames(const RenderArguments& a, const RenderJob& job, const SequenceOptions& options, Context& context) {
  SequenceReport report(context.progress, a.progress == "json");
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
  SequenceReport(context.progress, false).frameDone(job, statistics.frames.back(), 1);
  if (a.strict) requireNoWarnings(context.progress.warnings());
}

// throws: Error kUsage where the store is to hold labels and holds amounts.
fs::path requiredClass(const fs::path& store, bool labels) {
  if (labels && readManifest(store).volume_class != VolumeClass::kLabels)
    throw Error(ErrorCode::kUsage, store, "--labels",
                "holds amounts; convert its source with kiln convert --labels, or give it to --add");
  return store;
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
  if (a.repeat < 1) throw Error(ErrorCode::kUsage, "--repeat: expected at least 1");
  applyProgress(a.progress, context.progress);
  shareHeaps();
  const RenderJob job = jobOf(a);
  if (!context.ranks->first() && (a.dry_run || a.repeat > 1)) return;
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
  if (a.progress == "json" && (a.dry_run || a.repeat > 1))
    throw Error(ErrorCode::kUsage,
                "--progress json: tells of frames that become files, not of --dry-run and --repeat; --stats has their "
                "numbers");
  if (a.checkpoint) requireCheckpoint(job);
  const InputOptions input(a, job);
  if (a.dry_run) return sayCost(a, job, input, besideBytes(job, options), context.progress);
  const OutputFiles outputs = outputsOf(a, job);
  options.store_for = [&](const fs::path& volume) {
    ConvertOptions conversion;
    conversion.memory_bytes = job.speed.memory_bytes;
    conversion.command = context.command_line;
    conversion.time = timeNow();
    conversion.labels = input.areLabels(volume);
    const auto opened = [&](const SourceInfo& info) { outputs.requireNoneOf(info.files); };
    fs::path store = storeFor(volume, input.of(volume), conversion, context.progress, opened);
    outputs.requireNone(store);
    return requiredClass(std::move(store), conversion.labels);
  };
  if (a.repeat > 1)
    repeatFrame(a, job, options, context);
  else
    runFrames(a, job, options, context);
}

// An error of a job's camera, with the job's file where no option changed the camera.
Error inJob(const RenderArguments& a, const Error& error) {
  const std::string text = error.what();
  const bool of_camera = error.path().empty() && text.find("camera: ") != std::string::npos;
  const bool changed = a.projection || a.view || a.eye || a.target || a.up || a.azimuth || a.elevation;
  if (!of_camera || changed || extensionOf(a.input) != ".json") return error;
  return Error(error.code(), a.input, "", text);
}

void addCameraOptions(CLI::App& command, RenderArguments& a) {
  command.add_option("--projection", a.projection,
                     "perspective, orthographic, or equirectangular: a panorama of all directions round the eye, the "
                     "middle ahead, the top "
                     "up; its depths are distances from the eye");
  addNumber(command, "--fov", a.fov, "vertical field of view, perspective")->type_name("DEG");
  addNumber(command, "--height", a.height, "world units the image spans vertically, orthographic");
  command.add_option("--eye", a.eye, "where the eye is, in the world")->type_name("X,Y,Z");
  command.add_option("--target", a.target, "what it looks at; the volume's centre if not given")->type_name("X,Y,Z");
  command.add_option("--up", a.up, "what is up")->type_name("X,Y,Z");
  command.add_option("--view", a.view, "front, back, left, right, top or bottom, fitted to the volume");
  addNumber(command, "--azimuth", a.azimuth, "turn the eye about the up axis")->type_name("DEG");
  addNumber(command, "--elevation", a.elevation, "raise the eye")->type_name("DEG");
  addNumber(command, "--zoom", a.zoom, "2 draws twice as large");
  command.add_option("--stereo", a.stereo,
                     "draw what the left or the right eye of a pair sees, left or right, or both: an EXR of two parts, "
                     "views left and right, a PNG of one "
                     "beside the other; or two files where the name has %V, which becomes left and right");
  addNumber(command, "--interocular", a.interocular, "how far the eyes of a pair are apart, in world units");
  addNumber(command, "--convergence", a.convergence,
            "the depth at which both eyes see the same place; the target's if not given");
}

void addJobOptions(CLI::App& command, RenderArguments& a) {
  command.add_option("INPUT", a.input, "a store, a volume file (converted to a store beside it first), or JOB.json")
      ->required();
  command.add_option(
      "-o,--output", a.output,
      "the picture, .exr or .png, in whose name a run of # is the frame's number; or a video, .mp4, .mov, "
      ".mkv or .webm, by ffmpeg");
  command
      .add_option("--add", a.added,
                  "a store or volume file in the same picture, where its affine has it; once for each (options that "
                  "speak of a volume's values or voxels are INPUT's)")
      ->allow_extra_args(false)
      ->type_name("FILE");
  command
      .add_option("--labels", a.labels,
                  "a store or volume file of labels in the same picture, in a colour for each label; once for each")
      ->allow_extra_args(false)
      ->type_name("FILE");
  command
      .add_option("--add-tf", a.added_tfs,
                  "transfer function of each --add, then of each --labels, in their order; auto if not given")
      ->allow_extra_args(false)
      ->type_name("TF");
  command.add_option("--frames", a.frames, "draw these frames of the job: 7, 1-100, 1-100x2 or 1-10,20")
      ->type_name("FRAMES");
  addNumber(command, "--turntable", a.turntable, "turn the camera once about its target in this many frames")
      ->type_name("FRAMES");
  command.add_flag("--resume", a.resume, "keep the frames that are there and whole, and draw the others");
  command.add_flag("--checkpoint", a.checkpoint,
                   "draw a long frame in tiles of 512x512 pixels and keep those that are finished in a file beside the "
                   "picture, NAME.tiles, until that is written; with --resume go on from them");
  command
      .add_option("--rate", a.rate,
                  "frames a second of a video: 25, 23.976 or 24000/1001, which are the same; 24 if not given")
      ->type_name("FPS");
  command.add_option(
      "--progress", a.progress,
      "how far frames and the job are, with rate and time left: auto (default; a line that is drawn over, where there "
      "is a terminal), plain (a line every ten seconds), json (events on standard output, one a line) or none");
}

void addRankOptions(CLI::App& command, RenderArguments& a, Context& context) {
  addRankTimeout(command, context);
  command.add_option(
      "--distribute", a.distribute,
      "under mpirun, what the ranks share: tiles of frames, whole frames, bricks (each rank draws its own, "
      "and the partial images are composited), or auto (default): tiles or frames, whichever reads less");
  command
      .add_option("--share-reads", a.share_reads,
                  "under mpirun, with tiles or frames: on (default), each brick file is read from the disk by one rank "
                  "and sent to others that need it; off, each reads for itself, as where each has a fast copy of "
                  "the store")
      ->type_name("on|off");
  command
      .add_option("--store-local", a.store_local,
                  "with --distribute bricks: where each rank finds its part of the store, made by kiln split; a run "
                  "of # is the rank's number, from 1 on")
      ->type_name("DIR");
}

void addPixelOptions(CLI::App& command, RenderArguments& a) {
  command.add_option("--size", a.size, "pixels; 1024x1024 if not given, of a panorama 2048x1024")
      ->type_name("WIDTHxHEIGHT");
  command
      .add_option("--crop", a.crop,
                  "draw these pixels of the picture only, the same bit for bit but for --visibility quadtree")
      ->type_name("X,Y,W,H");
  command.add_option(
      "--samples", a.samples,
      "rays (of --lattice voxel sub-pixels) of a pixel: 1, 2, 4, 16, or auto (default), which takes more than "
      "one where voxels are small or the camera moves");
  command
      .add_option(
          "--aov", a.aovs,
          "more channels of the EXR: depth (Z, where alpha passes one half, and depth.mean, of all that is seen; along "
          "the view, infinite where there is nothing), normal (N.X, N.Y, N.Z, in the world), or both; value of --mode "
          "mip, minip or average (NaN where there is nothing)")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->type_name("NAME,...");
}

void addLookOptions(CLI::App& command, RenderArguments& a) {
  command.add_option("--tf", a.tf,
                     fmt::format("transfer function: a file (Kiln's, or FILE or FILE#NAME of ParaView's colour maps) "
                                 "or a preset: {}",
                                 presetList()));
  command
      .add_option("--window", a.window,
                  "stretch the transfer function so that it begins and ends with this window of values")
      ->type_name("CENTRE,WIDTH");
  addSceneArguments(command, a.scene);
}

void addVisibilityOptions(CLI::App& command, RenderArguments& a) {
  command.add_option("--visibility", a.visibility,
                     fmt::format("how hidden parts are found, one of {}: the picture is the same but for quadtree",
                                 fmt::join(kVisibilityNames, ", ")));
  command.add_option("--projected-area", a.area,
                     "what stands for a node of the octree when it is tested: box, the tightest, or sphere, as Lee "
                     "and Ihm have it");
  addNumber(command, "--quadtree-epsilon", a.epsilon, "enlarge projected areas by this, for --visibility quadtree")
      ->type_name("PIXELS");
  command.add_flag("--test-nodes-only", a.nodes_only,
                   "ask for nodes of the octree but not for each voxel, as Lee and Ihm have it");
  addNumber(command, "--tile", a.tile, "edge of the tiles that threads draw, a power of two from 64 on; 0: no tiles")
      ->type_name("PIXELS");
  addNumber(command, "--opacity-threshold", a.threshold,
            "alpha at which a pixel takes no more light; 0.998 if not given");
}

void addSamplingOptions(CLI::App& command, RenderArguments& a) {
  command.add_option("--mode", a.mode,
                     "what a pixel shows: composite (default), the light that the volume sends; mip, minip or average, "
                     "the greatest, least or mean value behind it, in the transfer function's colours (grey over the "
                     "range of values or --window, if --tf names none)");
  command.add_option(
      "--lattice", a.lattice,
      "where samples are: pixel (default; on pixels' rays; another name is ray) or voxel (the voxels alone, as Lee "
      "and Ihm have it)");
  command.add_option("--interpolation", a.interpolation,
                     "between voxels: linear (default), cubic (B-spline: smooth, blurs a little) or catmull-rom "
                     "(smooth, keeps the voxels' values)");
  addNumber(command, "--sample-distance", a.sample_distance,
            "between samples along a ray, from 0.25 to 1: more is faster, less more faithful; 0.5 if not given, "
            "and in any case half a pixel at the least")
      ->type_name("VOXELS");
  command.add_option("--level", a.level,
                     "auto, the levels whose voxels are about a pixel (default), or the number of one; 0 is finest");
  command
      .add_option("--part", a.part,
                  "draw a partial image, for kiln composite: the I-th of N boxes that fill the volume, or a box of "
                  "voxels; unlike --region it cuts nothing")
      ->type_name("I/N|X0,Y0,Z0,X1,Y1,Z1");
  command.add_flag("--skip-damaged", a.skip_damaged,
                   "draw bricks that are damaged or missing as nothing, warn of each, and succeed");
}

void addCostOptions(CLI::App& command, RenderArguments& a) {
  addMemory(command, a.memory,
            fmt::format("image, index and bricks, and for converting INPUT first; {} if not given", kDefaultMemory));
  command.add_option("--threads", a.threads, "threads; 0 takes all")->check(wholeNumberFrom(0, kMostThreads));
  command.add_flag("--strict", a.strict,
                   "exit with 1 where a warning says that the picture is not what was asked for: it is empty or of one "
                   "colour, bricks are damaged, or a frame or unit is unknown");
  command.add_flag("--dry-run", a.dry_run, "draw nothing; say how many bricks, what disk and what memory it takes");
  command.add_option("--stats", a.stats, "write what the render cost, as JSON")->type_name("FILE");
  command
      .add_option("--trace", a.trace,
                  "write what each thread did when, in Chrome's trace format, for Perfetto or chrome://tracing")
      ->type_name("FILE");
  addNumber(command, "--repeat", a.repeat, "draw the frame this many times, from the second on with bricks in memory")
      ->capture_default_str();
}

void addFileOptions(CLI::App& command, RenderArguments& a) {
  command.add_option("--exr-type", a.exr_type, "half or float");
  command.add_option("--compression", a.compression,
                     fmt::format("of an EXR: {}; zip if not given, the last two lose something",
                                 fmt::join(kExrCompressionNames, ", ")));
  command.add_flag("--deep", a.deep,
                   "a deep EXR: RGBA, Z and ZBack of each slab, for compositing with others; it has no background");
  addNumber(command, "--deep-samples", a.deep_samples,
            "deep samples of a pixel, at most: with more slabs, neighbours become one where that shows least; "
            "24 if not given");
  addNumber(command, "--deep-error", a.deep_error,
            "make one sample of neighbouring slabs as long as a cut at any depth shows at most so much else, "
            "of 1; 0 if not given");
  command.add_option("--owner", a.owner, "an EXR's attribute owner");
  command.add_option("--comments", a.comments, "an EXR's attribute comments");
  command.add_flag("--exr-statistics", a.exr_statistics, "what --stats writes, as an EXR's attribute kiln:statistics");
  addNumber(command, "--png-bits", a.png_bits, "8 or 16");
}

}  // namespace

void addRender(CLI::App& app, Context& context) {
  auto a = std::make_shared<RenderArguments>();
  CLI::App* command =
      app.add_subcommand("render", "draw a picture of a store, of a foreign file, or of what a job says");
  addJobOptions(*command, *a);
  addRankOptions(*command, *a, context);
  addPixelOptions(*command, *a);
  addCameraOptions(*command, *a);
  addLookOptions(*command, *a);
  addVisibilityOptions(*command, *a);
  addSamplingOptions(*command, *a);
  addCostOptions(*command, *a);
  addFileOptions(*command, *a);
  addSourceArguments(*command, a->source);
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
