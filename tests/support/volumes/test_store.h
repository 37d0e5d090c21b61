// Stores made of small volumes, in a place of their own on the disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "support/volumes/procedural.h"

namespace kiln::test {

/// An empty directory of the running test's own, under the build's test output; what an earlier run left there is
/// removed.
std::filesystem::path freshDirectory(const std::string& name);

/// Converts `volume` by the public API and returns the store's path, in freshDirectory(name). throws: as convert.
std::filesystem::path makeStore(const DenseVolume& volume, const std::string& name, std::int64_t brick_size = 32,
                                bool labels = false);

/// Writes `text` to a file; a failure fails the test.
void writeText(const std::filesystem::path& path, std::string_view text);

/// Every file below `directory`, by its path from there.
std::map<std::string, std::vector<std::byte>> filesOf(const std::filesystem::path& directory);

/// How many files of the store there are, each of them whole. throws: Error, the first damage that `verify` finds.
std::uint64_t wholeFiles(const std::filesystem::path& store);

/// Makes of a store one of format 1, whose index says nothing of sub-bricks, or of format 2, where they are larger.
void makeFormat(int format, const std::filesystem::path& store);

/// The text of a manifest with the checksum that it would have been written with.
std::string restamped(std::string manifest);

}  // namespace kiln::test
