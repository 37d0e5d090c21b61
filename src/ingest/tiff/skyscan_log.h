// The log that NRecon, the reconstruction program of SkyScan's micro-CTs, writes beside the slices.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ingest/source/slice_files.h"

namespace kiln {

/// The part of a log that describes slices.
struct ReconstructionLog {
  /// unit: micrometres.
  double pixel_um = 0;
  /// Distance of slices. unit: pixels.
  std::int64_t step = 1;
  /// Size of the slices; 0 if the log has none. unit: pixels.
  std::int64_t width = 0, height = 0;
};

/// Reads the section [Reconstruction]; nothing if it is missing or has no positive pixel size.
std::optional<ReconstructionLog> reconstructionLogOf(std::string_view text);

/// The size of a voxel by a log, and the log's file.
struct LoggedSpacing {
  glm::dvec3 spacing_um{0};
  std::filesystem::path log;
};

/// Returns the spacing of slices of width × height by the logs beside them. Logs named like the slices take precedence
/// over other logs. Adds a sentence to `notes` for each log that does not count. Nothing if no log counts, or if
/// several state different spacings. cost: reads the logs.
std::optional<LoggedSpacing> loggedSpacing(const SliceFiles& slices, std::int64_t width, std::int64_t height,
                                           std::vector<std::string>& notes);

}  // namespace kiln
