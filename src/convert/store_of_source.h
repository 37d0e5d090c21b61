// Finds whether a store holds a volume of files as they are now.
#pragma once

#include <cstdint>
#include <filesystem>

#include "ingest/source/volume_source.h"

namespace kiln {

/// True if `store` was made from the present state of the files, and holds the volume described by the source: a change
/// of --dims or --endian makes a different volume. Older stores lack the state of files; such a store must be younger
/// than the files.
/// throws: Error kBudget if the index of `store` does not fit `memory_bytes`.
bool isStoreOf(const std::filesystem::path& store, const SourceInfo& info, std::uint64_t memory_bytes = UINT64_MAX);

}  // namespace kiln
