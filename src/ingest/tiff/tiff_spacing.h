// Derives the spacing of a TIFF stack from its descriptions and tags.
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ingest/source/volume_source.h"
#include "ingest/tiff/skyscan_log.h"
#include "ingest/tiff/tiff_file.h"

namespace kiln {

/// Facts about a stack from the description of the first page, written by the program that saved the file.
struct StackNotes {
  const char* writer = "";
  /// The number of images in the file, and the stacks they form; 1 if the description has no number.
  std::int64_t images = 1, channels = 1, frames = 1;
  /// Slices of one stack; 0 if the description has no number. Image z of channel c at time t is
  /// z * slice_step + c * channel_step + t * frame_step.
  std::int64_t slices = 0, slice_step = 1, channel_step = 1, frame_step = 1;
  /// Names of the channels; empty texts without names.
  std::vector<std::string> channel_names;
  /// True if the number of images covers all files of the folder (OME), false if it covers this file (ImageJ).
  bool counts_all_files = false;
  /// The distance of slices in `unit`; 0 if the description has none.
  double spacing = 0;
  /// True if the resolution tags count pixels per `unit`.
  bool in_unit = false;
  /// True if tags with a unit of their own count pixels per that unit.
  bool tags_may_have_units = false;
  /// One unit of y in units of x.
  double y_scale = 1;
  /// The edges of a pixel in `unit`; 0 if the description has none.
  glm::dvec2 pixel{0};
  /// The unit of all lengths: "mm", "um"; empty for pixels and unknown units.
  std::string unit;
  /// Sentences about unknown units.
  std::vector<std::string> remarks;
  /// True if signed numbers are stored with 32768 added.
  bool offset_signed = false;
  /// The reason why the images cannot be told apart; empty if they can.
  std::string disorder;
  /// Any other calibration line, "values are -1000 + 2 times what is stored"; empty without a calibration.
  std::string line;
};

/// Parses ImageJ's KEY=VALUE lines after "ImageJ=", OME's XML, or tifffile's JSON; nothing for other descriptions.
std::optional<StackNotes> stackNotes(std::string_view description, int samples);

/// Returns spacing and unit of a volume of `dims`: `options.spacing`, else the stack's, else the log's, else by the
/// resolution tags, else 1. `notes` lists the choices made.
VolumeGeometry tiffGeometry(const Extent3& dims, const TiffPage& page, const std::optional<StackNotes>& stack,
                            const std::optional<LoggedSpacing>& log, const SourceOptions& options,
                            std::vector<std::string>& notes);

}  // namespace kiln
