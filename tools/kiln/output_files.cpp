
#include "output_files.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <optional>
#include <system_error>

#include "base/error.h"
#include "base/file/file.h"
#include "base/file/folder.h"
#include "image/file/image_file.h"
#include "say.h"
#include "store/store_reader.h"

namespace kiln::tool {
namespace fs = std::filesystem;
namespace {

// Returns the status of a regular file; otherwise nothing.
std::optional<struct stat> fileStatus(const fs::path& path) {
  struct stat status;
  if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  return status;
}

// A terminal or a discarding device has no content that further text could damage.
bool isStandardOutput(const fs::path& path) {
  struct stat output, found;
  return ::fstat(STDOUT_FILENO, &output) == 0 && !S_ISCHR(output.st_mode) && ::stat(path.c_str(), &found) == 0 &&
         output.st_dev == found.st_dev && output.st_ino == found.st_ino;
}

}  // namespace

void OutputFiles::add(const fs::path& path, const std::string& option) {
  if (path.empty()) return;
  if (const fs::path folder = behindLinks(path).parent_path(); folders_.insert(folder).second)
    requireOutsideStores(path, option);
  if (isStandardOutput(path)) sayToStandardError();
  if (const std::optional<struct stat> found = fileStatus(path))
    outputs_.push_back({path, option, found->st_dev, found->st_ino, found->st_nlink > 1});
}

void OutputFiles::requireNotThis(const fs::path& file) const {
  if (outputs_.empty()) return;
  const std::optional<struct stat> found = fileStatus(file);
  if (!found) return;
  for (const Output& output : outputs_) {
    if (output.device != found->st_dev || output.inode != found->st_ino) continue;
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: {} is the name of {}, which this command reads; name another file", output.option,
                            output.path.string(), output.path == file ? "a file" : file.string()));
  }
}

bool OutputFiles::mayBeIn(const fs::path& folder) const {
  std::error_code unknown;
  const fs::path whole = fs::canonical(folder, unknown);
  return std::any_of(outputs_.begin(), outputs_.end(), [&](const Output& output) {
    const fs::path place = fs::canonical(output.path, unknown);
    return output.linked || unknown || isWithin(place, whole);
  });
}

void OutputFiles::requireNone(const fs::path& read) const {
  std::error_code ignored;
  if (!fs::is_directory(read, ignored)) return requireNotThis(read);
  if (!mayBeIn(read)) return;
  forEachEntryBelow(read, [&](const fs::directory_entry& entry) {
    requireNotThis(entry.path());
    return Walk::kGoOn;
  });
}

void OutputFiles::requireNoneOf(const std::vector<fs::path>& read) const {
  for (const fs::path& file : read) requireNotThis(file);
}

void noteBlack(const Image& image, const fs::path& path, Progress& progress) {
  if (pictureFormatOf(path) != PictureFormat::kJpeg) return;
  for (std::size_t i = 3; i < image.rgba.size(); i += 4) {
    if (image.rgba.data()[i] >= 1) continue;
    progress.note(fmt::format("{}: a JPEG has no transparency; what is transparent is black. A PNG or a TIFF keeps it",
                              path.string()));
    return;
  }
}

}  // namespace kiln::tool
