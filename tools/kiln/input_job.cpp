#include "input_job.h"

#include <fmt/format.h>

#include <utility>
#include <variant>

#include "base/error.h"
#include "base/file/file.h"
#include "base/memory/memory.h"
#include "image/file/image_file.h"
#include "job/frame_list.h"
#include "job/job_facts.h"
#include "job/job_names.h"
#include "picture_job.h"
#include "scene_arguments.h"
#include "sequence/sequence_frames.h"
#include "sequence/series_volumes.h"
#include "store/manifest/read_manifest.h"

namespace kiln::tool {
namespace fs = std::filesystem;
namespace {

// Checks that a pair of eyes is complete once the flags are applied.
void requireStereo(const JobArguments& flags, const std::optional<Stereo>& of_job) {
  if (!of_job && !flags.has("--stereo") && flags.hasAny({"--interocular", "--convergence"}))
    throw Error(ErrorCode::kUsage, "--interocular, --convergence: no pair is drawn; add --stereo both, left or right");
  if (!of_job && flags.has("--stereo") && !flags.has("--interocular"))
    throw Error(ErrorCode::kUsage, "--stereo: how far the eyes are apart, --interocular, is missing");
}

void requirePicture(const PictureOptions& picture) {
  drawnPixels(picture.size, picture.crop);
  requireEngineOptions(picture);
}

void requireStillCamera(const JobArguments& flags, const RenderJob& job) {
  const bool keys = std::holds_alternative<CameraKeyframes>(job.animation.camera);
  const bool matrices = std::holds_alternative<CameraMatrices>(job.animation.camera);
  if ((!keys && !matrices) || flags.has("--turntable")) return;
  for (const char* flag : {"--eye", "--target", "--up", "--view", "--azimuth", "--elevation", "--zoom"}) {
    if (flags.has(flag))
      throw Error(ErrorCode::kUsage, fmt::format("{}: the job says by {} where the camera is in each frame; change it "
                                                 "there, or give --turntable",
                                                 flag, keys ? "keyframes" : "matrices"));
  }
  for (const char* flag : {"--fov", "--height"}) {
    if (keys && flags.has(flag))
      throw Error(ErrorCode::kUsage, fmt::format("{}: the job says by keyframes where the camera is in each frame; "
                                                 "change it there, or give --turntable",
                                                 flag));
  }
}

}  // namespace

void AddedVolumes::addTo(CLI::App& command) {
  const auto option = [&](const char* name, const char* type, std::vector<std::string>& value, const char* help) {
    command.add_option(name, value, help)->type_name(type)->group(nameOf(OptionGroup::kShown))->allow_extra_args(false);
  };
  option("--add", "FILE", added,
         "Also draw this volume, placed by its own affine. Options about values or voxels are INPUT's. Repeatable.");
  option("--labels", "FILE", labels, "Also draw this volume of labels, with a colour for each label. Repeatable.");
  option("--add-tf", "TF", functions,
         "Transfer function of each --add, then of each --labels, in their order (default auto). Repeatable.");
}

void AddedVolumes::apply(const JobArguments& flags, RenderJob& job) const {
  const std::size_t more = added.size() + labels.size();
  if (functions.size() > more)
    throw Error(ErrorCode::kUsage,
                fmt::format("--add-tf: {} given for {} volumes of --add and --labels; the first is of the first",
                            functions.size(), more));
  if (job.volumes.empty() && more == 0) return;
  if (job.volumes.empty()) makeFirstOfSeveral(job);
  VolumeOptions& first = job.volumes.front();
  if (flags.has("--tf")) {
    first.transfer_function = job.picture.transfer_function;
    first.functions.clear();
  }
  if (flags.has("--window")) first.window = job.picture.window;
  if (auto region = std::exchange(job.picture.clipping.region, std::nullopt)) first.clipping.region = region;
  for (std::size_t i = 0; i < more; ++i) {
    VolumeOptions volume;
    volume.labels = i >= added.size();
    volume.volume = volume.labels ? labels[i - added.size()] : added[i];
    if (i < functions.size()) volume.transfer_function = transferFunctionNamed(functions[i], "--add-tf");
    job.volumes.push_back(std::move(volume));
  }
}

bool isVolumeName(const fs::path& input) { return extensionOf(input) != ".json" && !isPictureName(input); }

RenderJob jobOfInput(const std::string& input, const JobArguments& flags, const AddedVolumes& volumes) {
  RenderJob job;
  if (extensionOf(input) == ".json") {
    job = readJob(input);
  } else if (isPictureName(input)) {
    job = jobOfPicture(input, parseBytes(flags.text("--memory").value_or(kDefaultMemory), "--memory"));
  } else {
    job.volume = input;
  }
  requireStillCamera(flags, job);
  requireStereo(flags, job.picture.stereo);
  if (const auto name = flags.text("--tf")) transferFunctionNamed(*name, "--tf");
  flags.apply(job);
  if (flags.hasAny({"--interocular", "--convergence"})) job.animation.stereo.clear();
  if (flags.text("--projection") == kProjectionNames[2] && !flags.has("--size") && isVolumeName(input))
    job.picture.size = kPanoramaSize;
  requirePicture(job.picture);
  volumes.apply(flags, job);
  return job;
}

std::vector<fs::path> inputsOf(const RenderJob& job) {
  std::vector<fs::path> out;
  const auto add = [&](const TransferFunctionChoice& still, const std::vector<Key<TransferFunctionChoice>>& keys) {
    const auto addFile = [&](const TransferFunctionChoice& function) {
      if (const auto* const file = std::get_if<fs::path>(&function)) out.push_back(fileOf(*file));
    };
    addFile(still);
    for (const Key<TransferFunctionChoice>& key : keys) addFile(key.value);
  };
  add(job.picture.transfer_function, job.animation.functions);
  for (const VolumeOptions& volume : job.volumes) add(volume.transfer_function, volume.functions);
  std::set<fs::path> volumes;
  for (const fs::path& volume : volumesOf(job)) {
    volumes.insert(volume);
    for (const int frame : framesOf(job)) volumes.insert(pathOfFrame(volume, frame));
  }
  out.insert(out.end(), volumes.begin(), volumes.end());
  return out;
}

InputOptions::InputOptions(const ForeignArguments& source, const RenderJob& job) : described_(source.volume({})) {
  const fs::path input = job.volumes.empty() ? job.volume : job.volumes.front().volume;
  names_ = namesIn(job, input);
  for (const VolumeOptions& volume : job.volumes) {
    if (volume.labels) labels_.merge(namesIn(job, volume.volume));
  }
}

std::set<fs::path> InputOptions::namesIn(const RenderJob& job, const fs::path& pattern) {
  std::set<fs::path> out = {pattern};
  for (const int frame : framesOf(job)) out.insert(pathOfFrame(pattern, frame));
  if (const std::vector<int> there = framesOnDisk(pattern); !there.empty())
    out.insert(pathOfFrame(pattern, there.front()));
  return out;
}

fs::path requiredClass(const fs::path& store, bool labels) {
  if (labels && readManifest(store).volume_class != VolumeClass::kLabels)
    throw Error(ErrorCode::kUsage, store, "--labels",
                "holds amounts; convert its source with kiln convert --labels, or give it to --add");
  return store;
}

}  // namespace kiln::tool
