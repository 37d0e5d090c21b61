// Tests the memory of a picture before it is allocated.
#pragma once

#include <cstdint>
#include <filesystem>

namespace kiln {

/// throws: Error kBudget, naming `path` and the missing memory, if `needed` exceeds `allowed`.
void requireMemory(std::uint64_t needed, std::uint64_t allowed, const std::filesystem::path& path);

}  // namespace kiln
