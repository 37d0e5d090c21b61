// The open volumes of a job, in one world.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/hash.h"
#include "job/frame/frame_scene.h"
#include "job/render_job.h"
#include "store/store_reader.h"

namespace kiln {

struct FrameRequest;
struct CompanionColors;

class OpenedVolumes {
 public:
  /// Opens the stores of all volumes and their companions. throws: as StoreReader and LabelMask.
  explicit OpenedVolumes(const RenderJob& job);
  /// Shares open volumes: one, or as many as the job's `volumes`; opens the stores of their companions. throws: Error
  /// kUsage for another number.
  OpenedVolumes(const RenderJob& job, std::span<const BrickedVolume* const> volumes);

  const std::vector<const BrickedVolume*>& all() const { return all_; }
  const BrickedVolume& first() const { return *all_.front(); }
  /// The volumes, if they are stores that this object opened; else none.
  const std::vector<const StoreReader*>& stores() const { return stores_; }
  std::vector<const Manifest*> manifests() const;
  /// Index checksums of the companions, in the order of inputVolumesOf.
  const std::vector<Hash128>& companions() const { return companions_; }
  /// Functions of the companions that colour volumes, one for each volume; nothing for colours of its own.
  const std::vector<std::optional<ShownFunction>>& colorFunctions() const { return color_functions_; }
  /// Sentences on assumptions about frames and units of companions.
  const std::vector<std::string>& assumptions() const { return assumptions_; }
  /// Adds the colours of companions to a request for these volumes.
  void dress(FrameRequest& request) const;

 private:
  void add(std::unique_ptr<BrickedVolume> volume, const Companions& companions, const RenderJob& job);
  std::unique_ptr<BrickedVolume> opened(const std::filesystem::path& companion, const Manifest& drawn,
                                        const RenderJob& job);
  void placeTogether(const RenderJob& job);

  std::vector<std::unique_ptr<BrickedVolume>> owned_;
  std::vector<const BrickedVolume*> all_;
  std::vector<const StoreReader*> stores_;
  std::vector<std::shared_ptr<const CompanionColors>> colors_;  // one per volume; null: its own colours
  std::vector<std::optional<ShownFunction>> color_functions_;
  std::vector<Hash128> companions_;
  std::vector<std::string> assumptions_;
  std::uint64_t held_bytes_ = 0;
};

/// Returns the companions of a volume that the job draws: one of its `volumes`, in order, or the only one.
const Companions& companionsOfVolume(const RenderJob& job, std::size_t volume);
/// Returns the function by which a file colours a volume. Reads the file of a function. throws: as resolve.
ShownFunction colorFunctionOf(const ColorByChoice& chosen, const Manifest& manifest);

/// Returns the geometry whose frame of reference and unit the picture has: the series', else the first known of the
/// volumes.
VolumeGeometry worldOf(const RenderJob& job, const std::vector<const Manifest*>& manifests);

}  // namespace kiln
