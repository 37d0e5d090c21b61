// Renders of a foreign file: the store that stands beside it, made once and made anew when the file, or what
// is said of it, has changed.
#pragma once

#include <functional>

#include "convert/convert.h"

namespace kiln {

/// The store for `input`: itself if it is one, else `input` with ".kiln" added, converted where it is missing, or made
/// of the file as it was once or with other source options; says so through `progress.note`. Of several processes one
/// makes it while the others wait. Calls opened(info), which may throw, once the source is known and before anything is
/// written. throws: as openSource and convert; Error kExists where a store that it would replace
/// was not made by a rendering (Provenance::command).
std::filesystem::path storeFor(const std::filesystem::path& input, const SourceOptions& source_options,
                               const ConvertOptions& options, Progress& progress,
                               const std::function<void(const SourceInfo&)>& opened = {});

/// The same where nothing is to be made; the source is opened in at most `memory_bytes`. throws: Error kUsage where a
/// foreign file has no such store yet; kBudget.
std::filesystem::path madeStoreFor(const std::filesystem::path& input, const SourceOptions& source_options,
                                   std::uint64_t memory_bytes,
                                   const std::function<void(const SourceInfo&)>& opened = {});

/// Whether each file of the source is as it was when `store` was made of them (of older stores, was last written before
/// it was finished), and it holds the volume that the source describes now: other --dims or another --endian make
/// another volume. throws: Error kBudget where the index of `store` does not fit `memory_bytes`.
bool isStoreOf(const std::filesystem::path& store, const SourceInfo& info, std::uint64_t memory_bytes = UINT64_MAX);

}  // namespace kiln
