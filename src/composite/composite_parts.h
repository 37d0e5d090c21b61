// Partial images put together: each shows a box of the volume, they are laid over one another in the order in which
// they are seen (DESIGN §8). What orders them stands in their headers.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/progress.h"
#include "image/file/image_file.h"
#include "image/image.h"
#include "store/manifest/manifest.h"

namespace kiln {

/// What a partial image's header says of its volume, beside the job: which it is, and where it is in the world.
std::string partOriginText(const Manifest& volume);

struct CompositedParts {
  Image image;
  ImageMetadata metadata;   // that of the whole picture
  double volume_share = 0;  // what of the volume the parts hold, from 0 to 1
};

/// The picture that the parts make, within rounding and what the opacity threshold leaves open: over one another, front
/// to back, then over the background. cost: memory for two pictures of their samples. throws: Error kUsage where there
/// are no parts or two of them do not belong together: of other volumes, cameras, sizes or looks, with a common voxel,
/// or without an order; kUnsupported for a file that is no partial image; kBudget where `memory_bytes` do not hold the
/// picture beside one of the parts; else as readImage; kCancelled.
CompositedParts compositeParts(const std::vector<std::filesystem::path>& parts, Progress& progress,
                               std::uint64_t memory_bytes = kUnlimitedBytes);

}  // namespace kiln
