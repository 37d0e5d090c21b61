// How far apart the pixels and pages of a TIFF stack are, as far as its files say.
#pragma once

#include "ingest/tiff_file.h"
#include "ingest/volume_source.h"

namespace kiln {

/// What ImageJ writes into the description of a stack's first page: lines of KEY=VALUE after "ImageJ=".
struct ImageJNotes {
  /// The number of images in the file, and what they are besides slices; 1 where it does not say.
  std::int64_t images = 1, channels = 1, frames = 1;
  /// The distance of slices; 0 where it does not say.
  double spacing = 0;
  /// "mm", "um"; empty where it does not say or says pixel.
  std::string unit;
};

/// Nothing where ImageJ did not write it.
std::optional<ImageJNotes> imageJNotes(std::string_view description);

/// Spacing and unit of a volume of `dims`: `options.spacing`, else ImageJ's, else the resolution tags, else 1. Adds a
/// sentence to `notes` where it had to choose.
VolumeGeometry tiffGeometry(const Extent3& dims, const TiffPage& page, const std::optional<ImageJNotes>& imagej,
                            const SourceOptions& options, std::vector<std::string>& notes);

}  // namespace kiln
