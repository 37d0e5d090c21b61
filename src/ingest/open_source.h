// Opens a foreign volume of any supported format.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "ingest/source/volume_source.h"

namespace kiln {

/// Refuses options that describe voxels, because a store contains the description. throws: Error kUsage, naming the
/// option.
void requireNoOptions(const std::filesystem::path& store, const SourceOptions& options);

/// A part of a file is named FILE:/PATH, such as scan.h5:/entry/data. Returns FILE if FILE exists and `input` does not;
/// otherwise `input`.
std::filesystem::path containerOf(const std::filesystem::path& input);

/// Returns /PATH of the input FILE:/PATH (containerOf); empty for any other input.
std::string partOf(const std::filesystem::path& input);

/// Opens `input` by its content (the first bytes, then the name); a directory by its slices.
/// throws: Error kNotFound; kFormat; kUnsupported (naming the content: vector data, an unknown format); kUsage if
/// raw data come without --dims and --type, or an option does not apply to the format; kBudget, before reading a grid
/// larger than `options.memory_bytes`.
std::unique_ptr<VolumeSource> openSource(const std::filesystem::path& input, const SourceOptions& options = {});

}  // namespace kiln
