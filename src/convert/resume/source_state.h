// How a volume's files were when they were read: whether they are the same files now.
//
// A state is three hashes. The first is of sizes, times of writing and, of several files, names. The second is of the
// times of change (ctime), which no program can set. The third is of contents: files of up to 64 MiB together are read
// whole, of larger ones evenly spaced blocks that begin with the first byte and end with the last one.
// Files are the same where the first hashes agree and the second or the third ones do: a copied or moved file has
// another ctime and needs its content read; a file that was replaced by one of equal size and time has both another
// ctime and another content. Inodes are left out: some network file systems number files anew at each mount.
// Limit: a larger file whose change is between the blocks, with its former time of writing put back, is not found.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kiln {

/// The state of `files` now; directories have none, as their slices are files of their own. Empty where there are no
/// files, as of phantoms. throws: Error kIo, kNotFound. cost: reads 64 MiB, or 8 KiB a file where there are more than
/// 8192.
std::string stateOf(const std::vector<std::filesystem::path>& files);

/// Whether `files` still are as `state` says; a state of an earlier version is its first hash alone. cost: reads them
/// as stateOf does where their ctimes differ.
bool isStateOf(const std::string& state, const std::vector<std::filesystem::path>& files);

/// A state without what differs between copies of the same files.
std::string portableState(const std::string& state);

/// The file that was written or replaced last. requires: there is a file.
std::filesystem::path lastChanged(const std::vector<std::filesystem::path>& files);

}  // namespace kiln
