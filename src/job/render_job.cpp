// A job's keys, each read and checked where it stands; what is not said keeps the default of the structs.
#include "job/render_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.h"
#include "base/file.h"
#include "base/memory/memory.h"
#include "job/frame_list.h"
#include "job/job_animation.h"
#include "job/job_names.h"
#include "job/job_parts.h"
#include "job/transfer_function_json.h"
#include "scene/scene_limits.h"
#include "scene/transfer/presets.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kLargestJob_bytes = 16u << 20;

void readPart(const JobObject& root, PictureOptions& picture) {
  if (!root.isText("part")) {
    picture.clipping.part = voxelBoxFrom(root, "part");
    return;
  }
  picture.part = partNumbered(*root.text("part", "a part"));
  if (!picture.part) root.refuse("part", "\"I/N\", I from 1 to N, or a box of voxels [x0, y0, z0, x1, y1, z1]");
}

fs::path besideJob(const std::string& text, const fs::path& job) { return job.parent_path() / text; }

// Several volumes: what a job of one has of its volume, each has for itself.
void readVolumes(const JobObject& root, RenderJob& job) {
  for (const char* key : {"volume", "transferFunction", "window", "region"}) {
    if (root.has(key)) root.complain(key, "is each volume's own where there are several; put it into \"volumes\"");
  }
  constexpr std::string_view kExpected = "a list of at least one volume [{volume, transferFunction, …}, …]";
  const auto volumes = root.objects("volumes", kExpected, {kMostVolumesOfJob, "volumes"});
  if (volumes->empty()) root.refuse("volumes", kExpected);
  for (const JobObject& object : *volumes) {
    object.requireKnown(job_keys::kVolume);
    VolumeOptions volume;
    const auto name = object.text("volume", "the name of a store or volume file");
    if (!name) object.complain("volume", "is missing; each of several volumes names its store or volume file");
    volume.volume = besideJob(*name, root.path());
    volume.labels = object.flag("labels").value_or(false);
    readTransferFunction(object, volume.transfer_function, volume.functions);
    volume.window = windowFrom(object);
    if (const auto shading = object.object("shading")) volume.shading = shadingFrom(*shading);
    volume.clipping = clippingFrom(object);
    job.volumes.push_back(std::move(volume));
  }
  job.volume = job.volumes.front().volume;
}

void readImage(const JobObject& object, PictureOptions& picture) {
  object.requireKnown(job_keys::kImage);
  picture.size.width = static_cast<int>(object.integer("width", 1, 65536).value_or(picture.size.width));
  picture.size.height = static_cast<int>(object.integer("height", 1, 65536).value_or(picture.size.height));
  picture.background = backgroundFrom(object);
  const auto legal = [](double v) { return v >= 0 && v <= 65536 && v == std::floor(v); };
  if (const auto c = object.numbers<4>("crop", "four whole numbers of pixels, [x, y, width, height]", legal)) {
    const auto at = [&](std::size_t i) { return static_cast<int>((*c)[i]); };
    picture.crop = PixelRect{at(0), at(1), at(0) + at(2), at(1) + at(3)};
  }
  for (const std::size_t place : object.choices("aov", kAovNames).value_or(std::vector<std::size_t>()))
    picture.aovs.of(static_cast<Aov>(place)) = true;
}

void readVisibility(const JobObject& object, RenderJob& job) {
  object.requireKnown(job_keys::kVisibility);
  VisibilityOptions& visibility = job.speed.visibility;
  if (const auto place = object.choice("method", kVisibilityNames))
    visibility.method = static_cast<VisibilityMethod>(*place);
  if (const auto place = object.choice("area", kProjectedAreaNames))
    visibility.area = static_cast<ProjectedArea>(*place);
  visibility.epsilon_px =
      static_cast<int>(object.integer("epsilon", 0, kLargestEpsilon).value_or(visibility.epsilon_px));
  static constexpr std::array<std::string_view, 2> kSamples = {"untested", "tested"};
  visibility.test_samples = object.choice("samples", kSamples).value_or(visibility.test_samples ? 1 : 0) == 1;
  const auto legal_threshold = [](double v) { return v > 0 && v <= 1; };
  job.picture.opacity_threshold = object.number("threshold", "a number above 0 and up to 1", legal_threshold)
                                      .value_or(job.picture.opacity_threshold);
}

// Reads the options that are plain numbers.
constexpr std::array<std::string_view, 1> kAuto = {"auto"};

bool legalSampleDistance(double voxels) { return voxels >= kLeastSampleDistance && voxels <= kMostSampleDistance; }

void readLatticeAndLevel(const JobObject& root, PictureOptions& picture) {
  if (const auto lattice = root.choice("lattice", kLatticeNames)) picture.lattice = latticeOfName(*lattice);
  if (const auto place = root.choice("interpolation", kInterpolationNames))
    picture.interpolation = static_cast<Interpolation>(*place);
  picture.sample_distance = root.number("sampleDistance", "a number of voxels from 0.25 to 1", legalSampleDistance)
                                .value_or(picture.sample_distance);
  if (root.isText("level"))
    root.choice("level", kAuto);
  else if (const auto level = root.integer("level", 0, 64))
    picture.level = static_cast<int>(*level);
}

void readSamples(const JobObject& root, PictureOptions& picture) {
  if (root.isText("samples")) {
    root.choice("samples", kAuto);
  } else if (const auto samples = root.integer("samples", 1, 16)) {
    picture.samples = static_cast<int>(*samples);
    if (!samplesKnown(*picture.samples)) root.refuse("samples", "auto, 1, 2, 4 or 16");
  }
}

void readSpeed(const JobObject& root, SpeedOptions& speed) {
  if (root.isText("memory")) {
    try {
      speed.memory_bytes = parseBytes(*root.text("memory", "an amount of memory such as \"2G\""));
    } catch (const Error&) {
      root.refuse("memory", "an amount of memory such as \"512M\" or \"2G\"");
    }
  } else if (const auto bytes = root.integer("memory", 1, std::int64_t{1} << 52)) {
    speed.memory_bytes = static_cast<std::uint64_t>(*bytes);
  }
  speed.threads = static_cast<unsigned>(root.integer("threads", 0, 4096).value_or(speed.threads));
  speed.tile_px = static_cast<int>(root.integer("tile", 0, 65536).value_or(speed.tile_px));
}

// A number, or a text such as "24000/1001".
std::optional<FrameRate> rateFrom(const JobObject& video) {
  std::string text;
  if (video.isText("rate"))
    text = *video.text("rate", kFrameRateForms);
  else if (const auto number = video.number("rate", kFrameRateForms, [](double v) { return v > 0; }))
    text = fmt::format("{}", *number);
  else
    return std::nullopt;
  const std::optional<FrameRate> rate = frameRateFrom(text);
  if (!rate) video.refuse("rate", kFrameRateForms);
  return rate;
}

void readOutput(const JobObject& root, OutputOptions& output) {
  if (const auto path = root.text("output", "a file name")) putOutput(besideJob(*path, root.path()), output);
  const auto files = root.objects("outputs", "a list of files [{path, content}, …]", {kMostOutputs, "files"});
  for (const JobObject& file : files.value_or(std::vector<JobObject>())) {
    file.requireKnown(job_keys::kOutput);
    const auto path = file.text("path", "a file name");
    if (!path) file.complain("path", "is missing; an output has the name of its file");
    const auto content = static_cast<Content>(file.choice("content", kContentNames).value_or(0));
    if (isVideo(*path)) file.complain("path", "a video is what \"output\" names");
    output.files.push_back({besideJob(*path, root.path()), content, std::nullopt});
  }
  if (const auto video = root.object("video")) {
    video->requireKnown(job_keys::kVideo);
    output.video.rate = rateFrom(*video).value_or(output.video.rate);
  }
  if (const auto exr = root.object("exr")) {
    exr->requireKnown(job_keys::kExr);
    static constexpr std::array<std::string_view, 2> kTypes = {"half", "float"};
    output.exr_float = exr->choice("type", kTypes).value_or(0) == 1;
    if (const auto place = exr->choice("compression", kExrCompressionNames))
      output.exr_compression = kExrCompressionNames[*place];
    output.owner = exr->text("owner", "a name").value_or("");
    output.comments = exr->text("comments", "a text").value_or("");
    output.statistics_in_header = exr->flag("statistics").value_or(false);
    output.deep = exr->flag("deep").value_or(false);
    DeepBound& bound = output.deep_bound;
    bound.samples = static_cast<int>(exr->integer("deepSamples", 1, DeepBound::kMostSamples).value_or(bound.samples));
    const auto legal_error = [](double v) { return v >= 0 && v <= 1; };
    bound.error = static_cast<float>(exr->number("deepError", "a number from 0 to 1", legal_error).value_or(0));
  }
  if (const auto png = root.object("png")) {
    png->requireKnown(job_keys::kPng);
    const std::int64_t bits = png->integer("bits", 8, 16).value_or(8);
    if (bits != 8 && bits != 16) png->refuse("bits", "8 or 16");
    output.png_bits = static_cast<int>(bits);
  }
}

}  // namespace

std::vector<fs::path> namesOf(const OutputOptions& output) {
  std::vector<fs::path> out{output.path};
  for (const OutputFile& file : output.files) out.push_back(file.path);
  out.push_back(output.video.path);
  std::erase_if(out, [](const fs::path& name) { return name.empty(); });
  return out;
}

bool isVideo(const fs::path& path) {
  const std::string ending = extensionOf(path);
  return ending == ".mp4" || ending == ".mov" || ending == ".mkv" || ending == ".webm";
}

void putOutput(const fs::path& path, OutputOptions& output) {
  (isVideo(path) ? output.video.path : output.path) = path;
}

bool samplesKnown(int samples) { return samples == 1 || samples == 2 || samples == 4 || samples == 16; }

bool oversamples(const PictureOptions& picture) { return picture.samples.value_or(1) != 1; }

int subPixelsAlongEdge(int samples) {
  if (!samplesKnown(samples))
    throw Error(ErrorCode::kUsage, fmt::format("--samples: expected 1, 2, 4 or 16 a pixel, found {}", samples));
  return samples == 1 ? 1 : samples <= 4 ? 2 : 4;
}

EngineChoice engineOf(const PictureOptions& picture) { return {picture.mode, picture.lattice, false}; }

EngineChoice engineOf(const RenderJob& job) { return {job.picture.mode, job.picture.lattice, !job.volumes.empty()}; }

void requireEngineOptions(const PictureOptions& picture) {
  requireOptions(engineOf(picture),
                 {picture.interpolation, picture.samples.value_or(1), picture.sample_distance, picture.aovs});
}

bool drawsPart(const PictureOptions& picture) { return picture.part || picture.clipping.part; }

void requirePart(const RenderJob& job) {
  if (!drawsPart(job.picture)) return;
  requireCapability(engineOf(job), &EngineCapabilities::parts, "--part: needs",
                    "draw one volume, with --mode composite");
  const OutputOptions& output = job.output;
  const std::filesystem::path& file = output.video.path.empty() ? output.path : output.video.path;
  if (!file.empty() && extensionOf(file) != ".exr")
    throw Error(ErrorCode::kUsage,
                fmt::format("--part: -o of a partial image ends in .exr (found {}); choose a name of "
                            "an EXR, whose header has the image's place",
                            file.string()));
  if (!output.files.empty())
    throw Error(ErrorCode::kUsage, fmt::format("--part: a partial image is one file, -o (found {} in outputs); leave "
                                               "outputs out",
                                               output.files.size()));
}

void requireVolumes(const RenderJob& job) {
  if (job.volumes.empty()) return;
  if (job.volumes.size() > kMostVolumesOfJob)
    throw Error(ErrorCode::kUsage, fmt::format("volumes: at most {} in one picture (found {}); draw fewer",
                                               kMostVolumesOfJob, job.volumes.size()));
  requireOptions(engineOf(job), {});
}

void makeFirstOfSeveral(RenderJob& job) {
  PictureOptions& picture = job.picture;
  VolumeOptions first;
  first.volume = job.volume;
  first.transfer_function = picture.transfer_function;
  first.functions = std::exchange(job.animation.functions, {});
  first.window = picture.window;
  first.clipping.region = std::exchange(picture.clipping.region, std::nullopt);
  job.volumes = {std::move(first)};
}

CameraSpec cameraFrom(const JobObject& object, JobKeys more) {
  object.requireKnown(job_keys::kCamera, more);
  CameraSpec spec;
  if (const auto place = object.choice("projection", kProjectionNames))
    spec.projection = static_cast<Projection>(*place);
  spec.eye = worldVectorFrom(object, "eye");
  spec.target = worldVectorFrom(object, "target");
  spec.up = worldVectorFrom(object, "up");
  if (spec.up && !(glm::length(*spec.up) > 0)) object.refuse("up", "a direction, which the zero vector is not");
  spec.fov_deg = object.number("fov", "a number of degrees in (0, 180)", [](double v) { return v > 0 && v < 180; });
  spec.height = object.number("height", "a number of world units above 0", legal::positiveLength);
  if (const auto place = object.choice("view", kSideNames)) spec.side = static_cast<Side>(*place);
  spec.azimuth_deg = object.number("azimuth", "a number of degrees from -3600 to 3600",
                                   [](double v) { return v >= -3600 && v <= 3600; });
  spec.elevation_deg =
      object.number("elevation", "a number of degrees from -90 to 90", [](double v) { return v >= -90 && v <= 90; });
  spec.zoom = object.number("zoom", "a number from 0.001 to 1000000", [](double v) { return v >= 1e-3 && v <= 1e6; });
  return spec;
}

// A name without a dot or a slash that is no preset is a misspelt preset, not a file.
std::optional<TransferFunctionChoice> transferFunctionChoiceFrom(const JobObject& owner, std::string_view key) {
  if (!owner.has(key)) return std::nullopt;
  if (!owner.isText(key)) return transferFunctionFrom(*owner.object(key));
  const std::string name = *owner.text(key, "a preset, a file or an object");
  if (isPreset(name)) return name;
  if (name.find_first_of("./") != std::string::npos) return besideJob(name, owner.path());
  const std::vector<std::string_view> words(presetNames().begin(), presetNames().end());
  owner.complain(key, "'" + name + "' is neither a preset nor a file name with an ending; did you mean '" +
                          std::string(nearestWord(name, words)) + "'?");
}

bool moves(const RenderJob& job) {
  const auto has_keys = [](const VolumeOptions& volume) { return !volume.functions.empty(); };
  return job.animation.any() || std::any_of(job.volumes.begin(), job.volumes.end(), has_keys);
}

std::vector<int> framesOf(const RenderJob& job) {
  if (!job.frames.empty()) return job.frames;
  Animation all = job.animation;
  for (const VolumeOptions& volume : job.volumes)
    all.functions.insert(all.functions.end(), volume.functions.begin(), volume.functions.end());
  const std::vector<int> out = all.frames();
  if (out.empty())
    throw Error(ErrorCode::kUsage,
                "no whole frame is between the first keyframe and the last; keys are at frames such as 1 and 48");
  if (out.size() > kMostFrames)
    throw Error(ErrorCode::kUsage, fmt::format("the keyframes span {} frames, more than {}", out.size(), kMostFrames));
  return out;
}

RenderJob parseJob(const std::string& text, const fs::path& path) {
  const JobObject root = JobObject::parse(text, path);
  root.requireKnown(job_keys::kRoot);
  root.number("kiln", "1, the job format of this version", [](double v) { return v == 1; });
  RenderJob job;
  if (root.has("volumes")) {
    readVolumes(root, job);
  } else {
    const auto volume = root.text("volume", "the name of a store or volume file");
    if (!volume) root.complain("volume", "is missing; a job names the store or volume file to draw");
    job.volume = besideJob(*volume, path);
  }
  const auto image = root.object("image");
  if (image) readImage(*image, job.picture);
  readCamera(root, job);
  if (job.picture.camera.projection == Projection::kEquirectangular &&
      !(image && (image->has("width") || image->has("height"))))
    job.picture.size = kPanoramaSize;
  readStereo(root, job);
  readTransferFunction(root, job.picture.transfer_function, job.animation.functions);
  job.picture.window = windowFrom(root);
  if (const auto shading = root.object("shading")) job.picture.shading = shadingFrom(*shading);
  readLights(root, job);
  readClipping(root, job);
  readPart(root, job.picture);
  readFrames(root, job);
  if (const auto visibility = root.object("visibility")) readVisibility(*visibility, job);
  if (const auto place = root.choice("mode", kModeNames)) job.picture.mode = static_cast<Mode>(*place);
  readLatticeAndLevel(root, job.picture);
  readSamples(root, job.picture);
  job.picture.skip_damaged = root.flag("skipDamaged").value_or(false);
  readSpeed(root, job.speed);
  job.distribution = static_cast<Distribution>(root.choice("distribute", kDistributionNames).value_or(0));
  job.share_reads = root.flag("shareReads").value_or(true);
  readOutput(root, job.output);
  if (const auto trace = root.text("trace", "a file name")) job.trace = besideJob(*trace, path);
  return job;
}

RenderJob readJob(const fs::path& path) { return parseJob(readTextFile(path, kLargestJob_bytes), path); }

}  // namespace kiln
