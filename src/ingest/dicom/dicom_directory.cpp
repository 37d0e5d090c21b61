#include "ingest/dicom/dicom_directory.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/file/file.h"
#include "base/text.h"
#include "ingest/dicom/dicom_elements.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr DicomTag kRecords = 0x00041220, kReferencedFile = 0x00041500;

bool holdsFile(const fs::path& folder, const std::string& name) {
  std::error_code ignored;
  return fs::exists(folder / name, ignored) || fs::exists(folder / lowered(name), ignored);
}

}  // namespace

bool isDicomDirectory(const fs::path& path) { return lowered(path.filename().string()) == "dicomdir"; }

std::string missingOf(const fs::path& path) {
  const DicomFile list = readDicomElements(File(path), {kRecords, kReferencedFile});
  const DicomElement* const records = list.set.find(kRecords);
  std::size_t missing = 0;
  std::string example;
  for (std::size_t i = 0; records != nullptr && i < records->items.size(); ++i) {
    std::string name = records->items[i].text(kReferencedFile);
    std::replace(name.begin(), name.end(), '\\', '/');
    if (name.empty() || holdsFile(path.parent_path(), name)) continue;
    if (missing++ == 0) example = name;
  }
  if (missing == 0) return "";
  return fmt::format("{} lists {} file{} not there: {}{}", path.filename().string(), missing,
                     missing == 1 ? " that is" : "s that are", inQuotes(example), missing == 1 ? "" : " and others");
}

}  // namespace kiln
