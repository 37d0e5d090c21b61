// Opens a foreign volume of any known format.
#pragma once

#include <filesystem>
#include <memory>

#include "ingest/source/volume_source.h"

namespace kiln {

/// That no option is given for a store, which says all of this itself. throws: Error kUsage, naming the option.
void requireNoOptions(const std::filesystem::path& store, const SourceOptions& options);

/// Opens `input` by what it holds (its first bytes, then its name); a directory by the slices in it.
/// throws: Error kNotFound, kFormat, kUnsupported (naming what it is: vector data, an unknown format), kUsage where raw
/// data comes without --dims and --type or an option does not apply to the format; kBudget, before reading a grid that
/// does not fit in `options.memory_bytes`.
std::unique_ptr<VolumeSource> openSource(const std::filesystem::path& input, const SourceOptions& options = {});

}  // namespace kiln
