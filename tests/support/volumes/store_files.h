#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace kiln::test {

/// Returns all files of a store by name, except the manifest, which names the source.
std::map<std::string, std::vector<std::byte>> storeFiles(const std::filesystem::path& store);

}  // namespace kiln::test
