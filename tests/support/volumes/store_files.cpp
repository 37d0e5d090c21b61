#include "support/volumes/store_files.h"

#include "base/file.h"

namespace kiln::test {
namespace fs = std::filesystem;

std::map<std::string, std::vector<std::byte>> storeFiles(const fs::path& store) {
  std::map<std::string, std::vector<std::byte>> out;
  for (const auto& entry : fs::recursive_directory_iterator(store)) {
    const std::string name = fs::relative(entry.path(), store);
    if (entry.is_regular_file() && name != "manifest.json") out[name] = readFile(entry.path());
  }
  return out;
}

}  // namespace kiln::test
