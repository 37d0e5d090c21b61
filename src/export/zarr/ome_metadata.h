// The headers of OME-Zarr 0.5 and Zarr 3 as text.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "export/source/exported_volume.h"

namespace kiln {

/// The name of a header.
inline constexpr const char* kZarrHeader = "zarr.json";
/// Largest header of an existing image that is read. unit: bytes.
inline constexpr std::uint64_t kLargestOmeHeader = 16 << 20;

/// Returns the paths of the arrays that the header of an OME-Zarr image lists; none for other texts.
std::vector<std::string> omeArrays(const std::string& header);

/// Name of an image, the description of its export, and the look and the range of its values. Equal exports have equal
/// descriptions.
struct OmeTitle {
  std::string name, contents;
  DeclaredLook look;
  ValueRange range;
};

/// Returns the description of the export that wrote the header of an image; empty for other texts.
std::string exportedContents(const std::string& header);

/// zarr.json of the group: axes, and the place of each level. `volumes` are levels of one pyramid, the finest first.
std::string omeGroupText(const std::vector<ExportedVolume>& volumes, const OmeTitle& title, ExportNotes& notes);

/// zarr.json of a level's array. shape: `shard` and `chunk` in voxels.
std::string zarrArrayText(const ExportedVolume& volume, const Extent3& shard, const Extent3& chunk);

}  // namespace kiln
