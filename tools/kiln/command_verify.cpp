#include <fmt/format.h>

#include "commands.h"
#include "store/store_reader.h"

namespace kiln::tool {

void addVerify(CLI::App& app, Context& context) {
  auto path = std::make_shared<std::string>();
  CLI::App* command = app.add_subcommand(
      "verify", "check every file of a store against its checksum, and every octree against its voxels");
  command->add_option("STORE", *path, "the store")->required();
  command->callback([path, &context] {
    context.action = [path] {
      const std::uint64_t files = StoreReader(*path).verify();
      fmt::print("{}: whole, {} files checked\n", *path, files);
    };
  });
}

}  // namespace kiln::tool
