#include "convert/source_state.h"

#include <fmt/format.h>

#include <system_error>

#include "base/error.h"
#include "base/hash.h"
#include "base/path_status.h"

namespace kiln {
namespace fs = std::filesystem;

std::string stateOf(const std::vector<fs::path>& files) {
  std::string all;
  for (const fs::path& file : files) {
    if (!isThere(file)) continue;
    std::error_code error;
    if (!fs::is_regular_file(file, error) && !error) continue;
    const std::uintmax_t size = error ? 0 : fs::file_size(file, error);
    const fs::file_time_type written = error ? fs::file_time_type() : fs::last_write_time(file, error);
    // A state without a file's time would match no later one, or the wrong one.
    if (error) throw systemError(error.value(), file, "looking at the source");
    // The names of slices are their order; one file may be moved with its store.
    all += fmt::format("{} {} {}\n", size, written.time_since_epoch().count(),
                       files.size() > 1 ? file.filename().string() : "");
  }
  return all.empty() ? all : toHex(hashOf(all));
}

}  // namespace kiln
