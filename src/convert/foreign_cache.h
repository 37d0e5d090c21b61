// Renders foreign files: a store beside the file, or in a folder of the user's choice, is made once, and made anew when
// the file or its description changes.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "convert/convert.h"

namespace kiln {

/// Returns whether the input is for StoreReader, which opens a store or reports why the input is none. True for a
/// store, a name of nothing, and a folder whose name ends in .kiln, such as an unfinished conversion.
bool isForStoreReader(const std::filesystem::path& input);

/// A volume file, or a store, and the folder for the store that is made of the file.
struct ForeignVolume {
  std::filesystem::path input;
  SourceOptions options;
  /// Made if it is missing. Empty: the folder of the file.
  std::filesystem::path store_directory;
};

/// Returns the name of the store that is made of a volume file. Beside the file: the file's name with ".kiln" appended.
/// In a `store_directory`: NAME-HASH.kiln, so that files of one name in several folders have a store each. HASH is 12
/// digits of the hash of the file's absolute path without links. Both contain the part of FILE:/PATH. A file whose
/// values are labels by the user's word alone (`as_labels`) has a second store: NAME.labels.kiln, or
/// NAME.labels-HASH.kiln in a `store_directory`.
std::filesystem::path storePathOf(const ForeignVolume& volume, bool as_labels = false);

/// Opens the file of a volume. throws: as openSource.
std::unique_ptr<VolumeSource> openedWithin(std::uint64_t memory_bytes, const ForeignVolume& volume);

/// Returns the input itself if it is a store, else storePathOf. Makes the store if it is missing, or was made from an
/// older state of the file or with different source options; reports the fact by `progress.note`. If several processes
/// need the store, a single process makes it. Calls opened(info), which may throw, once the source is open and before
/// anything is written.
/// throws: as openSource and convert; Error kExists if an existing store would be replaced that was not made by
/// render, slice, gallery or view (Provenance::command); kIo, naming --store, if the folder cannot be written to.
std::filesystem::path storeFor(const ForeignVolume& volume, const ConvertOptions& options, Progress& progress,
                               const std::function<void(const SourceInfo&)>& opened = {});

/// Returns the store of a volume's own values if it is made; `source` describes the volume.
std::optional<std::filesystem::path> madeStoreOf(const ForeignVolume& volume, const SourceInfo& source,
                                                 std::uint64_t memory_bytes);

/// Returns the store without making it; the source is opened in at most `memory_bytes`. `labels`: as ConvertOptions.
/// throws: Error kUsage if a foreign file has no such store yet; kBudget.
std::filesystem::path madeStoreFor(const ForeignVolume& volume, std::uint64_t memory_bytes, bool labels,
                                   const std::function<void(const SourceInfo&)>& opened = {});

}  // namespace kiln
