// Volume files in place of stores.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "commands.h"
#include "convert/foreign_cache.h"
#include "output_files.h"
#include "source_arguments.h"

namespace kiln::tool {

/// Options of a command that takes a volume file in place of a store.
struct ForeignArguments : SourceWords {
  std::string store_directory;
  /// throws: as SourceWords::resolve.
  ForeignVolume volume(const std::filesystem::path& input) const { return {input, resolve(), store_directory}; }
  /// Returns true if --store is given, and not by its variable alone.
  bool namesDirectory() const;
  /// Check that no option is given beside a store or a picture. The variable for --store may be set. An input that is
  /// no store, such as a name of nothing, passes requireNoneForStore. throws: Error kUsage.
  void requireNoneForStore(const std::filesystem::path& input) const;
  void requireNoneForPicture(const std::filesystem::path& picture) const;
};

/// Adds the options of SourceWords, and --store, which the variable KILN_STORE_DIR replaces.
void addForeignArguments(CLI::App& command, OptionFacts& facts, ForeignArguments& arguments);

/// Returns the input if it is a store, else the store of the volume file (storePathOf), which is made if it is missing
/// or older than the file. `labels`: the values of a file are labels. No output may be a file that is read. throws: as
/// storeFor; Error kUsage naming the output.
std::filesystem::path storeOfInput(const ForeignVolume& volume, std::uint64_t memory_bytes, const OutputFiles& outputs,
                                   Context& context, bool labels = false);

}  // namespace kiln::tool
