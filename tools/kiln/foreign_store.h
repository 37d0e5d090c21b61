// Volume files in place of stores.
#pragma once

#include <filesystem>
#include <string>

#include "commands.h"
#include "output_files.h"
#include "source_arguments.h"

namespace kiln::tool {

/// Returns `input` if it is a store, else the store beside the volume file, which is made if it is missing or older
/// than the file. No output may be a file that is read. throws: as storeFor; Error kUsage naming the output.
std::filesystem::path storeOfInput(const std::string& input, const SourceArguments& source, std::uint64_t memory_bytes,
                                   const OutputFiles& outputs, Context& context);

}  // namespace kiln::tool
