// Names of stores, and of the volumes in figures.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace kiln {

/// Digits, of 0 to f, of the hash that parts stores of files of equal names in a folder of stores.
inline constexpr std::size_t kStoreHashDigits = 12;

/// Returns the name of the store of a volume file in a folder of stores. `hash`: of kStoreHashDigits digits.
inline std::string hashedStoreName(std::string_view file, std::string_view hash) {
  return std::string(file) + "-" + std::string(hash) + ".kiln";
}

/// Returns the store's name for legends and texts: without folders and endings, and without the hash of a store of a
/// volume file.
std::string volumeNameOf(const std::filesystem::path& store);

}  // namespace kiln
