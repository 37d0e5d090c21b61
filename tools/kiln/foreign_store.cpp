#include "foreign_store.h"

#include "base/duration_text.h"
#include "job_arguments.h"

namespace kiln::tool {

void addForeignArguments(CLI::App& command, OptionFacts& facts, ForeignArguments& arguments) {
  addSourceArguments(command, facts, arguments);
  command
      .add_option("--store", arguments.store_directory,
                  "Folder for the store that is made of a volume file; the file's own folder by default.")
      ->type_name("DIR")
      ->envname("KILN_STORE_DIR")
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
