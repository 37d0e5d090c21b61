#include "export/zarr/ome_container.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.h"
#include "base/file/file.h"
#include "base/file/folder.h"
#include "base/file/path_status.h"
#include "base/text.h"
#include "export/output/pending_folder.h"
#include "export/zarr/ome_metadata.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// True for "c/0/12/3", the name of a chunk in the folder of its array.
bool isChunkName(std::string_view name) {
  const std::vector<std::string_view> parts = splitAt(name, '/');
  return parts.size() > 1 && parts.front() == "c" &&
         std::all_of(parts.begin() + 1, parts.end(), [](std::string_view part) {
           return !part.empty() && part.find_first_not_of("0123456789") == std::string_view::npos;
         });
}

// True for a file that the image's headers account for. `name` is relative to the folder.
bool isOfImage(std::string_view name, const std::vector<std::string>& arrays) {
  if (name == kZarrHeader || name == kUnfinishedMark) return true;
  return std::any_of(arrays.begin(), arrays.end(), [&](const std::string& array) {
    if (!name.starts_with(array + "/")) return false;
    const std::string_view inside = name.substr(array.size() + 1);
    return inside == kZarrHeader || isChunkName(inside);
  });
}

}  // namespace

void requireOmeContainer(const fs::path& folder) {
  const fs::path header = folder / kZarrHeader;
  std::vector<std::string> arrays;
  if (isThere(header)) arrays = omeArrays(readTextFile(header, kLargestOmeHeader));
  if (arrays.empty())
    throw Error(ErrorCode::kExists, folder, "", "is no OME-Zarr image, so it is not replaced; name another output");
  forEachEntryBelow(folder, [&](const fs::directory_entry& entry) {
    const bool is_link = entry.is_symlink();
    if (!is_link && entry.is_directory()) return Walk::kGoOn;
    if (!is_link && isOfImage(entry.path().lexically_relative(folder).string(), arrays)) return Walk::kGoOn;
    throw Error(ErrorCode::kExists, entry.path(), "",
                fmt::format("is no scale of the image {}, which is not replaced therefore; move it, or name another "
                            "output",
                            folder.string()));
  });
}

}  // namespace kiln
