#include "foreign_store.h"

#include "convert/foreign_cache.h"
#include "source_arguments.h"

namespace kiln::tool {

std::filesystem::path storeOfInput(const std::filesystem::path& input, const SourceOptions& source,
                                   std::uint64_t memory_bytes, const OutputFiles& outputs, Context& context,
                                   bool labels) {
  ConvertOptions conversion;
  conversion.memory_bytes = memory_bytes;
  conversion.command = context.command_line;
  conversion.time = timeNow();
  conversion.labels = labels;
  const auto opened = [&](const SourceInfo& info) { outputs.requireNoneOf(info.files); };
  std::filesystem::path store = storeFor(input, source, conversion, context.progress, opened);
  outputs.requireNone(store);
  return store;
}

}  // namespace kiln::tool
