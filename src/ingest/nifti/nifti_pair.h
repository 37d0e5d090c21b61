// The two files of a NIfTI or ANALYZE pair: NAME.hdr and NAME.img, also in capitals, each also with .gz behind it.
#pragma once

#include <filesystem>

namespace kiln {

enum class PairFile { kHeader, kImage };

/// True if the name ends in .gz.
bool endsInGz(const std::filesystem::path& path);

/// True if the name ends as that of the given file of a pair.
bool isNamed(PairFile file, const std::filesystem::path& path);

/// Returns the given file beside the other file of the pair: the first that is there, in the order NAME.hdr, NAME.HDR,
/// then with .gz, then with .GZ; without any the first name.
std::filesystem::path besideInPair(PairFile file, const std::filesystem::path& other);

}  // namespace kiln
