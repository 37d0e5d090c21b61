// Writes small volumes as stores, each in a separate folder.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "support/volumes/procedural.h"

namespace kiln::test {

/// Returns an empty directory of the running test under the build's test output. Files of an earlier run are removed.
std::filesystem::path freshDirectory(const std::string& name);

/// Converts `volume` by the public API and returns the store's path, in freshDirectory(name). throws: as convert.
std::filesystem::path makeStore(const DenseVolume& volume, const std::string& name, std::int64_t brick_size = 32,
                                bool labels = false);

/// Writes `text` to a file; a failure fails the test.
void writeText(const std::filesystem::path& path, std::string_view text);

/// Returns every file below `directory`, keyed by its relative path.
std::map<std::string, std::vector<std::byte>> filesOf(const std::filesystem::path& directory);

/// Verifies the store and returns the number of its files. throws: Error, the first damage found by `verify`.
std::uint64_t wholeFiles(const std::filesystem::path& store);

/// Converts a store to format 1, whose index has no sub-bricks, or to format 2, whose sub-bricks are larger.
void makeFormat(int format, const std::filesystem::path& store);

/// Returns the manifest's text with a valid checksum.
std::string restamped(std::string manifest);

}  // namespace kiln::test
