// Stores made of small volumes, in a place of their own on the disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "support/procedural.h"

namespace kiln::test {

/// An empty directory of the running test's own, under the build's test output; what an earlier run left there is
/// removed.
std::filesystem::path freshDirectory(const std::string& name);

/// Converts `volume` by the public API and returns the store's path, in freshDirectory(name). throws: as convert.
std::filesystem::path makeStore(const DenseVolume& volume, const std::string& name, std::int64_t brick_size = 32);

/// Every file below `directory`, by its path from there.
std::map<std::string, std::vector<std::byte>> filesOf(const std::filesystem::path& directory);

/// How many files of the store there are, each of them whole. throws: Error, the first damage that `verify` finds.
std::uint64_t wholeFiles(const std::filesystem::path& store);

}  // namespace kiln::test
