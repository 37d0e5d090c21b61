#include "foreign_store.h"

#include "convert/foreign_cache.h"

namespace kiln::tool {

std::filesystem::path storeOfInput(const std::string& input, const SourceArguments& source, std::uint64_t memory_bytes,
                                   const OutputFiles& outputs, Context& context) {
  ConvertOptions conversion;
  conversion.memory_bytes = memory_bytes;
  conversion.command = context.command_line;
  conversion.time = timeNow();
  const auto opened = [&](const SourceInfo& info) { outputs.requireNoneOf(info.files); };
  const std::filesystem::path store = storeFor(input, source.resolve(), conversion, context.progress, opened);
  outputs.requireNone(store);
  return store;
}

}  // namespace kiln::tool
