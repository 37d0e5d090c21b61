// How a volume's files were when it was read.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kiln {

/// Another text once one of the files has another size or, of several, another name, or was written at another time;
/// directories say nothing here, as their slices are files of their own. Empty of no files, as of phantoms.
std::string stateOf(const std::vector<std::filesystem::path>& files);

}  // namespace kiln
