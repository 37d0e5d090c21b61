#include "sequence/rank_facts.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <string>
#include <utility>

#include "job/frame/frame_scene.h"
#include "job/frame_list.h"
#include "job/job_facts.h"
#include "job/job_names.h"
#include "sequence/frame_files.h"
#include "sequence/opened_volumes.h"
#include "store/manifest/read_manifest.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Returns the manifest without its history: equal voxels converted at different times are one volume.
std::string textOf(Manifest manifest) {
  manifest.source = {};
  return manifestText(manifest);
}

RankFact factOf(const fs::path& store, const Manifest& manifest) {
  const std::string checksum = toHex(manifest.index_checksum);
  RankFact out{"store", checksum + toHex(hashOf(std::string_view(textOf(manifest))))};
  out.difference = [store, digits = checksum.size()](const std::string& there, const std::string& here) {
    const std::string of_there = there.substr(0, digits), of_here = here.substr(0, digits);
    return of_there == of_here ? fmt::format("the store {} has another manifest.json there than here", store.string())
                               : fmt::format("the store {} is another volume, with checksum {} there and {} here",
                                             store.string(), of_there, of_here);
  };
  return out;
}

// Reads the volumes of the frames in turn; consecutive frames with equal volumes share the reading.
class FrameFacts {
 public:
  FrameFacts(const RenderJob& job, const StoreFor& stores) : job_(job), stores_(stores) {}

  std::vector<RankFact> of(int frame, bool with_text) {
    std::vector<RankFact> out = open(frame);
    const FrameScene scene = scenes_->at(frame);
    const std::vector<OutputFile> files = filesOf(job_, frame);
    if (with_text && !files.empty()) {
      RenderJob unnamed = opened_;  // a rank may have a part or copy of the store in another place
      forEachVolume(unnamed, [](const fs::path&) { return fs::path(); });
      out.push_back({"the job", frameText(unnamed, files.front(), scene), jobDifference});
    }
    std::string hashes;
    for (const OutputFile& file : files) hashes += contentHash(opened_, file, scene, manifests_.front());
    out.push_back({fmt::format("frame {}", frame), hashes, [frame](const std::string&, const std::string&) {
                     return fmt::format("frame {} is another picture there than here", frame);
                   }});
    return out;
  }

 private:
  std::vector<RankFact> open(int frame) {
    RenderJob job = jobAtFrame(job_, frame);
    if (scenes_ && inputVolumesOf(job) == volumes_) return {};
    volumes_ = inputVolumesOf(job);
    scenes_.reset();
    manifests_.clear();
    forEachVolume(job, stores_);
    opened_ = std::move(job);
    std::vector<RankFact> out;
    SceneInputs inputs;
    const auto companionAt = [&](const fs::path& store) {
      Manifest manifest = readManifest(store);
      out.push_back(factOf(store, manifest));
      inputs.companions.push_back(manifest.index_checksum);
      return manifest;
    };
    const std::vector<fs::path> volumes = volumesOf(opened_);
    for (std::size_t i = 0; i < volumes.size(); ++i) {
      manifests_.push_back(readManifest(volumes[i]));
      out.push_back(factOf(volumes[i], manifests_.back()));
      const Companions& companions = companionsOfVolume(opened_, i);
      if (companions.mask) companionAt(companions.mask->volume);
      inputs.colors.emplace_back();
      if (const auto& colors = companions.color_by)
        inputs.colors.back() = colorFunctionOf(*colors, companionAt(colors->volume));
    }
    std::vector<const Manifest*> manifests;
    for (const Manifest& manifest : manifests_) manifests.push_back(&manifest);
    scenes_.emplace(opened_, manifests, inputs);
    return out;
  }

  const RenderJob& job_;
  const StoreFor& stores_;
  std::vector<fs::path> volumes_;
  RenderJob opened_;
  std::vector<Manifest> manifests_;
  std::optional<SceneOfJob> scenes_;  // refers to both
};

}  // namespace

std::vector<RankFact> jobFacts(const RenderJob& job, const SequenceOptions& options) {
  std::vector<std::string> volumes, outputs;
  for (const fs::path& volume : inputVolumesOf(job)) volumes.push_back(volume.string());
  for (const fs::path& path : namesOf(job.output)) outputs.push_back(path.string());
  return {{"the list of frames", framesText(framesOf(job))},
          {"the list of volumes", fmt::format("{}", fmt::join(volumes, ", "))},
          {"the list of outputs", fmt::format("{}", fmt::join(outputs, ", "))},
          {"--distribute", std::string(nameIn(kDistributionNames, job.distribution))},
          {"--share-reads", job.share_reads ? "on" : "off"},
          {"--store-local", options.store_local.empty() ? "not given" : "given"},
          {"--resume", options.resume ? "given" : "not given"}};
}

std::vector<RankFact> frameFacts(const RenderJob& job, const StoreFor& stores) {
  const std::vector<int> frames = framesOf(job);
  FrameFacts facts(job, stores);
  std::vector<RankFact> out;
  for (const int frame : frames) {
    try {
      for (RankFact& fact : facts.of(frame, frame == frames.front())) out.push_back(std::move(fact));
    } catch (const Error& error) {
      if (frames.size() == 1) throw;
      out.push_back({fmt::format("frame {}", frame), error.what()});
    }
  }
  return out;
}

}  // namespace kiln
