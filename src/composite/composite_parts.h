// Composites partial images, each of one box of the volume, front to back. Camera and box come from the images'
// headers.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/progress.h"
#include "image/file/image_file.h"
#include "image/image.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// Returns the header text by which partial images identify their volume: dimensions, affine, checksum of the index.
std::string partOriginText(const Manifest& volume);

struct CompositedParts {
  Image image;
  ImageMetadata metadata;            // of the whole picture; owner and comments of parts that differ are joined by "; "
  double volume_share = 0;           // share of the volume that the parts hold, from 0 to 1
  std::filesystem::path drawn_from;  // folder from which relative names in the job count; empty if they are absolute
};

/// Composites the parts front to back, then over the background. The result differs from the whole picture by rounding
/// and by the transmittance below the opacity threshold. `medium`: of the file that the picture is for; for a
/// display it has no planes. cost: memory for two pictures of samples. throws: Error kUsage without parts, or if two
/// parts differ in volume, camera, size or appearance, share a voxel, or have no order of visibility; kUnsupported for
/// a file that is no partial image, or deep; kBudget if `memory_bytes` do not hold the picture beside one part;
/// kCancelled; as readImage.
CompositedParts compositeParts(const std::vector<std::filesystem::path>& parts, Progress& progress,
                               std::uint64_t memory_bytes = kUnlimitedBytes, Medium medium = Medium::kLight);

}  // namespace kiln
