#include "foreign_store.h"

#include <cstdlib>

#include "base/duration_text.h"
#include "base/error.h"
#include "base/file/path_status.h"
#include "ingest/open_source.h"
#include "job_arguments.h"

namespace kiln::tool {
namespace {
constexpr const char* kStoreVariable = "KILN_STORE_DIR";
}

bool ForeignArguments::namesDirectory() const {
  const char* const by_variable = std::getenv(kStoreVariable);
  return !store_directory.empty() && (by_variable == nullptr || store_directory != by_variable);
}

void ForeignArguments::requireNoneForStore(const std::filesystem::path& input) const {
  if (!isForStoreReader(input) || !isThere(input)) return;
  if (namesDirectory())
    throw Error(ErrorCode::kUsage, input, "",
                "--store applies to volume files only, and this is a store; leave it out");
  requireNoOptions(input, resolve());
}

void ForeignArguments::requireNoneForPicture(const std::filesystem::path& picture) const {
  if (any() || namesDirectory())
    throw Error(ErrorCode::kUsage, picture, "", "is a picture, and options of volume files are given; leave them out");
}

void addForeignArguments(CLI::App& command, OptionFacts& facts, ForeignArguments& arguments) {
  addSourceArguments(command, facts, arguments);
  command
      .add_option("--store", arguments.store_directory,
                  "Folder for the store that is made of a volume file; the file's own folder by default.")
      ->type_name("DIR")
      ->envname(kStoreVariable)
      ->group(nameOf(OptionGroup::kForeign));
}

std::filesystem::path storeOfInput(const ForeignVolume& volume, std::uint64_t memory_bytes, const OutputFiles& outputs,
                                   Context& context, bool labels) {
  ConvertOptions conversion;
  conversion.memory_bytes = memory_bytes;
  conversion.command = context.command_line;
  conversion.time = timeNow();
  conversion.labels = labels;
  const auto opened = [&](const SourceInfo& info) { outputs.requireNoneOf(info.files); };
  std::filesystem::path store = storeFor(volume, conversion, context.progress, opened);
  outputs.requireNone(store);
  return store;
}

}  // namespace kiln::tool
