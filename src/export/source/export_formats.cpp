#include "export/source/export_formats.h"

#include "base/error.h"
#include "base/file/path_status.h"

namespace kiln {

void requirePlace(const ExportTarget& target, const std::filesystem::path& file) {
  if (!target.overwrite && isThere(file))
    throw Error(ErrorCode::kExists, file, "", "is there already; name another output or give --overwrite");
  target.disk.requirePlaceToRename(file);
}

}  // namespace kiln
