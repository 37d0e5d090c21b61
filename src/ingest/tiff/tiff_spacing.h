// How far apart the pixels and pages of a TIFF stack are, as far as its files say.
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ingest/source/volume_source.h"
#include "ingest/tiff/tiff_file.h"

namespace kiln {

/// What a program wrote of its stack into the description of the first page.
struct StackNotes {
  const char* writer = "";
  /// The number of images in the file, and the stacks they form; 1 where the description has no number.
  std::int64_t images = 1, channels = 1, frames = 1;
  /// Whether the number of images is of all files of the folder (OME) and not of this file alone (ImageJ).
  bool counts_all_files = false;
  /// The distance of slices in `unit`; 0 where the description has none.
  double spacing = 0;
  /// Whether the resolution tags count pixels in `unit`: `y_scale` converts from the unit of y to the unit of x.
  bool in_unit = false;
  double y_scale = 1;
  /// The edges of a pixel in `unit`; 0 where the description has none.
  glm::dvec2 pixel{0};
  /// The unit of all lengths: "mm", "um"; empty for pixels and unknown units.
  std::string unit;
  /// Sentences on units that are unknown.
  std::vector<std::string> remarks;
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
