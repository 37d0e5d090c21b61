#include "sequence/opened_volumes.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "grid/shared_world.h"
#include "job/series_look.h"

namespace kiln {

OpenedVolumes::OpenedVolumes(const RenderJob& job) {
  std::uint64_t held = 0;
  const auto open = [&](const std::filesystem::path& path) {
    auto store = std::make_unique<StoreReader>(path, job.speed.memory_bytes, held);
    held += store->heldBytes();
    stores_.push_back(store.get());
    all_.push_back(store.get());
    owned_.push_back(std::move(store));
  };
  for (const VolumeOptions& volume : job.volumes) open(volume.volume);
  if (job.volumes.empty()) open(job.volume);
  placeTogether(job);
}

OpenedVolumes::OpenedVolumes(const RenderJob& job, std::span<const BrickedVolume* const> volumes) {
  const std::size_t expected = std::max<std::size_t>(job.volumes.size(), 1);
  if (volumes.size() != expected)
    throw Error(ErrorCode::kUsage,
                fmt::format("volumes: the job has {} (found {} open); give as many", expected, volumes.size()));
  for (const BrickedVolume* const volume : volumes) all_.push_back(owned_.emplace_back(volume->share()).get());
  placeTogether(job);
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
