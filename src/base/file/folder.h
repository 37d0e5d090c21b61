// Lists folders on a disk that may fail.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

namespace kiln {

/// Continuation after an entry. kPassOver skips the contents of the entry, a folder.
enum class Walk { kGoOn, kPassOver, kStop };
using VisitEntry = std::function<Walk(const std::filesystem::directory_entry&)>;

/// Visits every entry of a folder, in the system's order. An open that a signal interrupts is repeated.
/// throws: Error kIo, naming the folder, where the system cannot list it.
void forEachEntry(const std::filesystem::path& folder, const VisitEntry& visit);
/// Visits the entries of a folder and of all folders below it, each folder before its entries. Links are not followed.
/// throws: as forEachEntry.
void forEachEntryBelow(const std::filesystem::path& folder, const VisitEntry& visit);

/// True where `path` is `folder` or lies below it, by the names alone. requires: both are canonical.
bool isWithin(const std::filesystem::path& path, const std::filesystem::path& folder);

/// Returns `folder` as seen from the folder of `file`, such as "..". Nothing where both are one folder, where a path is
/// unreadable, and where both share only the root: the name of a folder such as /home/ann would enter a file that may
/// be published.
std::optional<std::string> folderSeenFrom(const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace kiln
