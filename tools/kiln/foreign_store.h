// Volume files in place of stores.
#pragma once

#include <cstdint>
#include <filesystem>

#include "commands.h"
#include "ingest/source/volume_source.h"
#include "output_files.h"

namespace kiln::tool {

/// Returns `input` if it is a store, else the store beside the volume file, which is made if it is missing or older
/// than the file. `labels`: the values of a file are labels. No output may be a file that is read. throws: as storeFor;
/// Error kUsage naming the output.
std::filesystem::path storeOfInput(const std::filesystem::path& input, const SourceOptions& source,
                                   std::uint64_t memory_bytes, const OutputFiles& outputs, Context& context,
                                   bool labels = false);

}  // namespace kiln::tool
