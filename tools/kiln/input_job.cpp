#include "input_job.h"

#include <algorithm>
#include <variant>

#include "base/error.h"
#include "base/file/file.h"
#include "base/memory/memory.h"
#include "image/file/image_file.h"
#include "job/frame_list.h"
#include "job/job_facts.h"
#include "job_arguments.h"
#include "picture_job.h"
#include "scene/transfer/presets.h"
#include "scene_arguments.h"
#include "sequence/sequence_frames.h"
#include "sequence/series_volumes.h"
#include "store/manifest/read_manifest.h"
#include "store/store_reader.h"

namespace kiln::tool {
namespace fs = std::filesystem;

namespace {

// Refuses a pair of eyes without a distance before a file is converted. The refusal for stores states a usual distance.
void requireInterocularOfFiles(const RenderJob& job) {
  if (lacksInterocular(job) &&
      !std::ranges::all_of(volumesOf(job), [](const fs::path& volume) { return isStore(volume); }))
    throw Error(ErrorCode::kUsage,
                "--stereo: needs --interocular, the distance between both eyes; one thirtieth of the distance to the "
                "volume is usual");
}

// Returns true if all volumes, in all frames, are stores.
bool drawsStoresAlone(const RenderJob& job) {
  const bool series = isSeries(job);
  std::set<fs::path> names;
  for (const fs::path& volume : inputVolumesOf(job)) {
    for (const int frame : framesOf(job)) names.insert(series ? pathOfFrame(volume, frame) : volume);
  }
  return std::ranges::all_of(names, isStore);
}

}  // namespace

void AddedArguments::addTo(CLI::App& command, OptionFacts& facts) {
  const auto option = [&](const char* name, const char* type, std::vector<std::string>& value, const char* help) {
    return command.add_option(name, value, help)
        ->type_name(type)
        ->group(nameOf(OptionGroup::kShown))
        ->allow_extra_args(false);
  };
  option("--add", "FILE", added,
         "Also draw this volume, placed by its own affine. Options about values or voxels are INPUT's. Repeatable.");
  option("--labels", "FILE", labels, "Also draw this volume of labels, with a colour for each label. Repeatable.");
  facts.offer(
      option("--add-tf", "TF", functions,
             "Transfer function of each --add, then of each --labels, in their order (default auto). Repeatable."),
      presetNames());
}

AddedVolumes AddedArguments::resolve() const {
  AddedVolumes out;
  out.added.assign(added.begin(), added.end());
  out.labels.assign(labels.begin(), labels.end());
  for (const std::string& function : functions) out.functions.push_back(transferFunctionNamed(function, "--add-tf"));
  return out;
}

bool isVolumeName(const fs::path& input) { return extensionOf(input) != ".json" && !isPictureName(input); }

RenderJob jobOfInput(const std::string& input, const GivenFlags& flags, const AddedArguments& volumes) {
  RenderJob job;
  if (extensionOf(input) == ".json") {
    job = readJob(input);
  } else if (isPictureName(input)) {
    job = jobOfPicture(input, parseBytes(flags.text("--memory").value_or(kDefaultMemory), "--memory"));
  } else {
    job.volume = input;
  }
  if (const auto name = flags.text("--tf")) transferFunctionNamed(*name, "--tf");
  applyGiven(flags, job);
  addVolumes(volumes.resolve(), flags, job);
  requireInterocularOfFiles(job);
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
  const auto addColors = [&](const Companions& companions) {
    if (companions.color_by) add(companions.color_by->transfer_function, {});
  };
  addColors(job.companions);
  for (const VolumeOptions& volume : job.volumes) addColors(volume.companions);
  std::set<fs::path> volumes;
  for (const fs::path& volume : inputVolumesOf(job)) {
    volumes.insert(volume);
    for (const int frame : framesOf(job)) volumes.insert(pathOfFrame(volume, frame));
  }
  out.insert(out.end(), volumes.begin(), volumes.end());
  return out;
}

InputOptions::InputOptions(const ForeignArguments& source, const RenderJob& job)
    : described_(source.volume({})),
      names_(namesInFrames(job, job.volumes.empty() ? job.volume : job.volumes.front().volume)),
      labels_(labelVolumesOf(job)) {
  if (source.namesDirectory() && drawsStoresAlone(job))
    throw Error(ErrorCode::kUsage,
                "--store applies to volume files only, and every volume of this job is a store; leave it out");
}

fs::path requiredClass(const fs::path& store, bool labels) {
  if (labels && readManifest(store).volume_class != VolumeClass::kLabels)
    throw Error(ErrorCode::kUsage, store, "labels",
                "holds amounts; convert its source with kiln convert --labels, or draw it with --add");
  return store;
}

}  // namespace kiln::tool
