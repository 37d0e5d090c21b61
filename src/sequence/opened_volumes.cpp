#include "sequence/opened_volumes.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <variant>

#include "base/error.h"
#include "companion/accompanied_volume.h"
#include "companion/color_values.h"
#include "companion/label_mask.h"
#include "frame/pass/frame_request.h"
#include "grid/shared_world.h"
#include "job/frame/series_look.h"
#include "job/job_facts.h"
#include "job/transfer_function_choice.h"

namespace kiln {

namespace {

// Without a function, labels and files that declare a look have their own colours. The automatic function of other
// files shows surfaces by opacity, in colours that are alike; a map distinguishes values.
TransferFunction colorsOf(const ColorByChoice& chosen, const Manifest& manifest) {
  const auto* const name = std::get_if<std::string>(&chosen.transfer_function);
  const bool declared = manifest.volume_class == VolumeClass::kLabels || manifest.look.ramp;
  const bool by_map = name != nullptr && *name == "auto" && !declared;
  return resolve(by_map ? TransferFunctionChoice(std::string("fire")) : chosen.transfer_function, std::nullopt,
                 manifest);
}

}  // namespace

const Companions& companionsOfVolume(const RenderJob& job, std::size_t volume) {
  return job.volumes.empty() ? job.companions : job.volumes[volume].companions;
}

ShownFunction colorFunctionOf(const ColorByChoice& chosen, const Manifest& manifest) {
  ShownFunction out = shownFunction(chosen.volume, colorsOf(chosen, manifest), manifest);
  out.colors_only = true;
  return out;
}

OpenedVolumes::OpenedVolumes(const RenderJob& job) {
  requireCompanions(job);
  requireChannels(job);
  const std::size_t count = std::max<std::size_t>(job.volumes.size(), 1);
  bool all_stores = true;
  for (std::size_t i = 0; i < count; ++i) {
    const std::filesystem::path& path = job.volumes.empty() ? job.volume : job.volumes[i].volume;
    auto store = std::make_unique<StoreReader>(path, job.speed.memory_bytes, held_bytes_);
    held_bytes_ += store->heldBytes();
    stores_.push_back(store.get());
    all_stores = all_stores && !companionsOfVolume(job, i).any();
    add(std::move(store), companionsOfVolume(job, i), job);
  }
  if (!all_stores) stores_.clear();
  placeTogether(job);
}

OpenedVolumes::OpenedVolumes(const RenderJob& job, std::span<const BrickedVolume* const> volumes) {
  requireCompanions(job);
  requireChannels(job);
  const std::size_t expected = std::max<std::size_t>(job.volumes.size(), 1);
  if (volumes.size() != expected)
    throw Error(ErrorCode::kUsage,
                fmt::format("volumes: the job has {} (found {} open); give as many", expected, volumes.size()));
  for (std::size_t i = 0; i < expected; ++i) add(volumes[i]->share(), companionsOfVolume(job, i), job);
  placeTogether(job);
}

std::unique_ptr<BrickedVolume> OpenedVolumes::opened(const std::filesystem::path& companion, const Manifest& drawn,
                                                     const RenderJob& job) {
  auto out = std::make_unique<StoreReader>(companion, job.speed.memory_bytes, held_bytes_);
  held_bytes_ += out->heldBytes();
  out->placeIn(drawn.geometry());
  companions_.push_back(out->manifest().index_checksum);
  if (const std::string& assumption = out->manifest().assumption; !assumption.empty())
    assumptions_.push_back(companion.string() + ": " + assumption);
  return out;
}

// The companions of a volume are made here and nowhere else.
void OpenedVolumes::add(std::unique_ptr<BrickedVolume> volume, const Companions& chosen, const RenderJob& job) {
  const Manifest& drawn = volume->manifest();
  std::vector<std::unique_ptr<Companion>> companions;
  if (chosen.mask)
    companions.push_back(
        std::make_unique<LabelMask>(opened(chosen.mask->volume, drawn, job), chosen.mask->labels, drawn));
  std::shared_ptr<const CompanionColors> colors;
  std::optional<ShownFunction> shown;
  if (chosen.color_by) {
    std::unique_ptr<BrickedVolume> values = opened(chosen.color_by->volume, drawn, job);
    const Manifest& manifest = values->manifest();
    shown = colorFunctionOf(*chosen.color_by, manifest);
    colors = std::make_shared<const CompanionColors>(CompanionColors{shown->function, manifest.type, manifest.range});
    companions.push_back(std::make_unique<ColorValues>(std::move(values), drawn));
  }
  if (!companions.empty()) volume = std::make_unique<AccompaniedVolume>(std::move(volume), std::move(companions));
  colors_.push_back(std::move(colors));
  color_functions_.push_back(std::move(shown));
  all_.push_back(volume.get());
  owned_.push_back(std::move(volume));
}

void OpenedVolumes::dress(FrameRequest& request) const {
  request.colors = colors_.front();
  for (std::size_t i = 0; i < request.volumes.size(); ++i) request.volumes[i].colors = colors_[i];
}

// A single volume keeps its own frame of reference and unit.
void OpenedVolumes::placeTogether(const RenderJob& job) {
  if (owned_.size() == 1 && !job.series) return;
  const VolumeGeometry world = worldOf(job, manifests());
  for (const std::unique_ptr<BrickedVolume>& volume : owned_) volume->placeIn(world);
}

std::vector<const Manifest*> OpenedVolumes::manifests() const {
  std::vector<const Manifest*> out;
  for (const BrickedVolume* const volume : all_) out.push_back(&volume->manifest());
  return out;
}

VolumeGeometry worldOf(const RenderJob& job, const std::vector<const Manifest*>& manifests) {
  if (job.series) return job.series->volumes.front().geometry();
  std::vector<VolumeGeometry> volumes;
  for (const Manifest* const manifest : manifests) volumes.push_back(manifest->geometry());
  return sharedWorld(volumes);
}

}  // namespace kiln
