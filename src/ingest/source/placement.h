// Places a volume in the world by the user's words. Voxels keep their order and values: the affine and the patient
// frame change.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "ingest/source/volume_source.h"

namespace kiln {

/// Returns the letters in capitals; empty if `text` is none of the 48 orientations.
std::optional<AxisLetters> axisLettersOf(std::string_view text);

/// Returns the geometry of a volume placed so. Voxel (0,0,0) keeps its place under `axes`, and the box keeps its place
/// under `flip`. throws: Error kUsage, naming `file` and the option, if the file states what the option would.
VolumeGeometry placed(const VolumeGeometry& geometry, const Placement& placement, const std::string& file);

/// Returns a note for a file that states no orientation, and that nobody has placed; else an empty text.
std::string orientationNote(const SourceInfo& info);

}  // namespace kiln
