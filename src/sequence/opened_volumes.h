// The open volumes of a job, in one world.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "job/render_job.h"
#include "store/store_reader.h"

namespace kiln {

class OpenedVolumes {
 public:
  /// Opens the stores of all volumes. throws: as StoreReader.
  explicit OpenedVolumes(const RenderJob& job);
  /// Shares open volumes: one, or as many as the job's `volumes`. throws: Error kUsage for another number.
  OpenedVolumes(const RenderJob& job, std::span<const BrickedVolume* const> volumes);

  const std::vector<const BrickedVolume*>& all() const { return all_; }
  const BrickedVolume& first() const { return *all_.front(); }
  /// The volumes, if they are stores that this object opened; else none.
  const std::vector<const StoreReader*>& stores() const { return stores_; }
  std::vector<const Manifest*> manifests() const;

 private:
  void placeTogether(const RenderJob& job);

  std::vector<std::unique_ptr<BrickedVolume>> owned_;
  std::vector<const BrickedVolume*> all_;
  std::vector<const StoreReader*> stores_;
};

/// Returns the geometry whose frame of reference and unit the picture has: the series', else the first known of the
/// volumes.
VolumeGeometry worldOf(const RenderJob& job, const std::vector<const Manifest*>& manifests);

}  // namespace kiln
