// How far apart the pixels and pages of a TIFF stack are, as far as its files say.
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ingest/tiff_file.h"
#include "ingest/volume_source.h"

namespace kiln {

/// What a program wrote of its stack into the description of the first page.
struct StackNotes {
  const char* writer = "";
  /// The number of images in the file, and what they are besides slices; 1 where it does not say.
  std::int64_t images = 1, channels = 1, frames = 1;
  /// The distance of slices; 0 where it does not say.
  double spacing = 0;
  /// Of pixels: those of the resolution tags are in `unit` where `in_unit`, else as `pixel` says where that is not 0.
  bool in_unit = false;
  glm::dvec2 pixel{0};
  /// "mm", "um"; empty where it does not say, says pixel or a unit of its own.
  std::string unit;
  /// Signed numbers are stored 32768 larger.
  bool offset_signed = false;
  /// Of another line through the values, "values are -1000 + 2 times what is stored"; empty where there is none.
  std::string line;
};

/// ImageJ's lines of KEY=VALUE after "ImageJ=", OME's XML, or the shape that tifffile writes; nothing of others.
std::optional<StackNotes> stackNotes(std::string_view description);

/// Spacing and unit of a volume of `dims`: `options.spacing`, else the stack's, else the resolution tags, else 1. Adds
/// a sentence to `notes` where it had to choose.
VolumeGeometry tiffGeometry(const Extent3& dims, const TiffPage& page, const std::optional<StackNotes>& stack,
                            const SourceOptions& options, std::vector<std::string>& notes);

}  // namespace kiln
