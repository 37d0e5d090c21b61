#include "base/file/temporary_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <utility>

#include "base/file/renamed_error.h"
#include "base/file/same_file.h"

namespace kiln {
namespace fs = std::filesystem;

namespace {

// Upper bound of processes that write one file at once. On a disk without locks each killed process uses up a slot.
constexpr int kSlots = 99;
// Slots without a file after which there are no leftovers: processes take the first free slot.
constexpr int kMostGaps = 4;

fs::path slotOf(const fs::path& path, int slot) { return fmt::format("{}.kiln-{:03}.tmp", path.string(), slot); }

int openSlot(const fs::path& slot) { return ::open(slot.c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC); }

}  // namespace

TemporaryFile::TemporaryFile(const fs::path& path) : destination_(path) {
  for (int slot = 1; slot <= kSlots; ++slot) {
    path_ = slotOf(path, slot);
    if (!claim()) continue;
    removeLeftovers(path, slot + 1);
    return;
  }
  throw Error(ErrorCode::kIo, path, "",
              fmt::format("cannot be written: {} temporary files such as {} are in the way; remove them", kSlots,
                          path_.filename().string()));
}

bool TemporaryFile::claim() {
  do {
    file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  } while (file_ < 0 && errno == EINTR);
  const bool made = file_ >= 0;
  if (!made && errno != EEXIST) throw systemError(errno, destination_, "creating the file");
  if (!made) file_ = openSlot(path_);
  if (file_ < 0) return false;
  const bool locked = lockAtOnce(file_), no_locks = !locked && errno != EWOULDBLOCK;
  try {
    // A file found in the slot is emptied, unless its former owner renamed it to its destination meanwhile.
    if ((locked || (made && no_locks)) && leadsTo(path_, file_) &&
        (made || (isOwnFile(file_) && ::ftruncate(file_, 0) == 0)))
      return true;
  } catch (const Error& error) {
    if (made) removeIfStill(path_, file_);
    ::close(std::exchange(file_, -1));
    throw named(error);
  }
  ::close(std::exchange(file_, -1));
  return false;
}

void TemporaryFile::removeLeftovers(const fs::path& path) { removeLeftovers(path, 1); }

void TemporaryFile::removeLeftovers(const fs::path& path, int first_slot) {
  int gaps = 0;
  for (int slot = first_slot; slot <= kSlots && gaps < kMostGaps; ++slot) {
    const fs::path name = slotOf(path, slot);
    const int file = openSlot(name);
    gaps = file < 0 && errno == ENOENT ? gaps + 1 : 0;
    if (file < 0) continue;
    if (lockAtOnce(file) && isOwnFile(file)) removeIfStill(name, file);
    ::close(file);
  }
}

Error TemporaryFile::named(const Error& error) const { return renamed(error, path_, destination_); }

TemporaryFile::~TemporaryFile() {
  removeIfStill(path_, file_);
  ::close(file_);
}

}  // namespace kiln
