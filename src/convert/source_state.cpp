#include "convert/source_state.h"

#include <fmt/format.h>

#include <system_error>

#include "base/hash.h"

namespace kiln {
namespace fs = std::filesystem;

std::string stateOf(const std::vector<fs::path>& files) {
  std::string all;
  for (const fs::path& file : files) {
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored)) continue;
    // The names of slices are their order; one file may be moved with its store.
    all += fmt::format("{} {} {}\n", fs::file_size(file, ignored),
                       fs::last_write_time(file, ignored).time_since_epoch().count(),
                       files.size() > 1 ? file.filename().string() : "");
  }
  return all.empty() ? all : toHex(hashOf(all));
}

}  // namespace kiln
