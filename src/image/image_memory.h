// A check of the memory that pictures take, before they take it.
#pragma once

#include <cstdint>
#include <filesystem>

namespace kiln {

/// throws: Error kBudget naming `path` and the memory that is missing, where `needed` is more than `allowed`.
void requireMemory(std::uint64_t needed, std::uint64_t allowed, const std::filesystem::path& path);

}  // namespace kiln
