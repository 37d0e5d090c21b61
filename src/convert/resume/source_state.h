// Detects whether the files of a volume have changed since they were read.
//
// A state is three hashes:
// 1. sizes, modification times and, of several files, names;
// 2. change times (ctime), which no program can set;
// 3. contents: files of up to 64 MiB together are read whole, larger files at evenly spaced blocks from the first byte
//   to the last.
// Files are unchanged if hash 1 agrees and hash 2 or 3 agrees. A copied or moved file has another ctime, so its
// content decides. A file replaced by another file of equal size and time differs in ctime and content. Inodes are
// ignored: some network file systems renumber files at each mount.
// A tree (a folder of chunks, up to millions of files) counts by hashes 1 and 2, summed over its files in any order.
// Both must agree, so a copy of a tree counts as changed. Linked folders and names with ".kiln" are passed over.
// Limit: a change of a larger file between the blocks, with its former modification time restored, is not found.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kiln {

/// Returns the present state of `files`. Directories are skipped, because their slices are listed as files. Empty if
/// there are no files, as for phantoms. throws: Error kIo, kNotFound. cost: reads 64 MiB, or 8 KiB per file for more
/// than 8192 files; looks at each file of the trees.
std::string stateOf(const std::vector<std::filesystem::path>& files,
                    const std::vector<std::filesystem::path>& trees = {});

/// True if `files` still have `state`; a state of an earlier version is hash 1 alone. cost: reads the files as
/// stateOf if their ctimes differ.
bool isStateOf(const std::string& state, const std::vector<std::filesystem::path>& files,
               const std::vector<std::filesystem::path>& trees = {});

/// Returns a state without the hash that differs between copies of the files.
std::string portableState(const std::string& state);

/// Returns the file with the latest change. requires: there is a file.
std::filesystem::path lastChanged(const std::vector<std::filesystem::path>& files);

}  // namespace kiln
