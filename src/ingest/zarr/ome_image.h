// Images as OME-Zarr describes them: axes with units, scales with sizes and places.
// Source: ngff.openmicroscopy.org, versions 0.1 to 0.5, and RFC-4 for anatomical orientation.
#pragma once

#include "ingest/zarr/zarr_image.h"

namespace kiln {

/// The "multiscales" of a group.
class OmeImage {
 public:
  OmeImage(std::filesystem::path group, const JsonNode& ome, const JsonNode& multiscale, bool others)
      : group_(std::move(group)), ome_(ome), multiscale_(multiscale), has_others_(others) {}

  std::size_t scales() const;
  /// Returns the scale that the array at `path`, relative to the group, holds.
  std::optional<std::size_t> scaleOf(const std::filesystem::path& path) const;
  /// Opens a scale, 0 being the finest. throws: as openZarrImage.
  ZarrImage open(std::size_t scale, const SourceOptions& options) const;

 private:
  std::filesystem::path arrayOf(const JsonNode& dataset) const;
  std::vector<ArrayAxis> axes(std::size_t count) const;
  std::vector<JsonNode> omeroChannels() const;
  std::vector<std::string> channels() const;
  void addLook(ArrayVolume& volume) const;

  std::filesystem::path group_;
  JsonNode ome_, multiscale_;
  bool has_others_;
};

/// Returns the image that the attributes of `group` describe; nothing if there is none. throws: Error kFormat, kIo.
std::optional<OmeImage> readOmeImage(const std::filesystem::path& group, std::uint64_t memory_bytes);

/// Throws Error kUnsupported if `group` is a plate of wells.
void refusePlate(const std::filesystem::path& group, std::uint64_t memory_bytes);

}  // namespace kiln
