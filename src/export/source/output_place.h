// Checks of an output's name, before hours of work.
#pragma once

#include <filesystem>
#include <set>

#include "base/file/file.h"
#include "store/store_reader.h"

namespace kiln {

/// The files that an export must not replace: files of stores, and the source of the exported store.
class ExportInputs {
 public:
  /// Source files are looked for by the names that the conversion was given: in the working directory, and beside the
  /// store.
  explicit ExportInputs(const StoreReader& store);
  /// Follows links. throws: Error kUsage if `out` is such a file, is in a store, or is a folder that holds a source
  /// file.
  void requireNone(const std::filesystem::path& out) const;

 private:
  std::set<std::filesystem::path> sources_;  // whole names without links
};

/// throws: Error kExists if the output is there and must not be replaced.
void requireAbsent(const std::filesystem::path& out, bool overwrite);

/// Checks that a file of the output can be made. throws: as requireAbsent, ExportInputs::requireNone and
/// FileSystem::requirePlaceToRename.
void requirePlace(const StoreReader& store, const std::filesystem::path& file, bool overwrite, FileSystem& disk);

}  // namespace kiln
