#include "base/file/file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <utility>

#include "base/error.h"
#include "base/file/path_status.h"
#include "base/file/renamed_error.h"
#include "base/file/same_file.h"
#include "base/file/temporary_file.h"
#include "base/text.h"
#include "base/uninterrupted.h"
#include "base/work_count.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Closes the file on destruction. After a write, call `close` explicitly, because a failed close is a failed write.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }
  int close() { return ::close(std::exchange(fd_, -1)); }

 private:
  int fd_;
};

// Writes all bytes, at `offset`, or at the current position of the file if no offset is given.
void writeAll(int file, const fs::path& path, std::span<const std::byte> data,
              std::optional<std::uint64_t> offset = {}) {
  std::size_t done = 0;
  while (done < data.size()) {
    const auto rest = data.subspan(done);
    const ssize_t put = offset ? ::pwrite(file, rest.data(), rest.size(), static_cast<off_t>(*offset + done))
                               : ::write(file, rest.data(), rest.size());
    if (put < 0 && errno == EINTR) continue;
    if (put < 0) throw systemError(errno, path, "writing at byte " + std::to_string(offset.value_or(0) + done));
    done += static_cast<std::size_t>(put);
    countWork();
  }
}

// Writes a first part of the bytes past the page cache and returns its length, which may be 0. The caller writes the
// remaining bytes through the cache; that second write reports any failure of the disk.
std::size_t writePastCache(int file, std::span<const std::byte> data) {
  constexpr std::size_t kBlock = 4096, kBuffer = 256 * kBlock;
  const int flags = ::fcntl(file, F_GETFL);
  if (data.size() < kBuffer || flags < 0 || ::fcntl(file, F_SETFL, flags | O_DIRECT) != 0) return 0;
  // O_DIRECT needs whole blocks and block-aligned memory.
  const std::unique_ptr<void, void (*)(void*)> buffer(std::aligned_alloc(kBlock, kBuffer), std::free);
  std::size_t done = 0;
  while (buffer && data.size() - done >= kBlock) {
    const std::size_t bytes = std::min(kBuffer, (data.size() - done) / kBlock * kBlock);
    std::memcpy(buffer.get(), data.data() + done, bytes);
    const ssize_t put = ::pwrite(file, buffer.get(), bytes, static_cast<off_t>(done));
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) break;
    done += static_cast<std::size_t>(put);
    countWork();
    if (done % kBlock != 0) break;
  }
  ::fcntl(file, F_SETFL, flags);
  return done;
}

// System calls read a name up to its first NUL and would reach another file.
void requireWholeName(const fs::path& path) {
  if (path.native().find('\0') != std::string::npos)
    throw Error(ErrorCode::kUsage, path, "", "a file name has no NUL character; remove it from the name");
}

int openUninterrupted(const fs::path& path, int flags, mode_t mode = 0) {
  requireWholeName(path);
  return uninterrupted([&] { return ::open(path.c_str(), flags, mode); });
}

// Opens a device. Opening may block, so a signal must end the wait (EINTR): Ctrl-C then works.
int openInPlace(const fs::path& path, int flags) { return ::open(path.c_str(), O_WRONLY | O_CLOEXEC | flags); }

constexpr int kMostLinks = 40;  // the limit of Linux

// Returns the target of a link; nothing if `path` is no link.
std::optional<fs::path> behindLink(const fs::path& path) {
  std::error_code unknown;
  if (!fs::is_symlink(fs::symlink_status(path, unknown))) return std::nullopt;
  if (!mayBeFollowed(path)) throw Error(ErrorCode::kIo, path, "", "is a link made by another user; name its target");
  const fs::path target = fs::read_symlink(path, unknown);
  return unknown ? std::nullopt : std::optional(path.parent_path() / target);
}

// Returns the file descriptor of this process that a name such as /dev/stdout stands for.
std::optional<int> descriptorNamed(const fs::path& path) {
  std::error_code unknown;
  const fs::path own = fs::canonical("/proc/self/fd", unknown);
  if (unknown) return std::nullopt;
  // The last link but one decides: the last link leads to the open file, which may lie anywhere or have no name any
  // more.
  std::optional<fs::path> at = path;
  for (int i = 0; at && i < kMostLinks; ++i, at = behindLink(*at)) {
    if (fs::canonical(at->has_parent_path() ? at->parent_path() : ".", unknown) != own || unknown) continue;
    if (const std::optional<int> number = numberOf<int>(at->filename().string())) return number;
  }
  return std::nullopt;
}

// Opens a file of this user for writing from its start: a new file, or an emptied one of this name.
// Removes a link, a pipe or another user's file of this name and never writes through it.
// Devices and open files (isWrittenInPlace) are opened as they are. Returns a negative number and sets errno on
// failure.
int openToWrite(const fs::path& path) {
  constexpr int kNew = O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC;
  const int made = openUninterrupted(path, kNew, 0666);
  if (made >= 0 || errno != EEXIST) return made;
  // A second open would start at offset 0 and overwrite the bytes already written, so the descriptor is duplicated.
  if (const std::optional<int> open = descriptorNamed(path)) return ::fcntl(*open, F_DUPFD_CLOEXEC, 0);
  if (isWrittenInPlace(path)) return openInPlace(path, 0);
  const int found = openUninterrupted(path, O_WRONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (found >= 0 && isOwnFile(found) && ::ftruncate(found, 0) == 0) return found;
  if (found >= 0) ::close(found);
  ::unlink(path.c_str());
  return openUninterrupted(path, kNew, 0666);
}

int openToAppend(const fs::path& path) {
  constexpr int kEnd = O_WRONLY | O_APPEND | O_NOFOLLOW | O_CLOEXEC;
  const int found = openUninterrupted(path, kEnd | O_NONBLOCK);
  struct stat status;
  if (found >= 0 && ::fstat(found, &status) == 0 && S_ISREG(status.st_mode)) return found;
  if (found >= 0) ::close(found);
  if (const std::optional<int> open = descriptorNamed(path)) return ::fcntl(*open, F_DUPFD_CLOEXEC, 0);
  if (isWrittenInPlace(path)) return openInPlace(path, O_APPEND);
  return openUninterrupted(behindLinks(path), kEnd | O_CREAT, 0666);
}

}  // namespace

// O_NONBLOCK: opening a pipe would block until a program writes into the pipe.
File::File(const fs::path& path)
    : path_(path), descriptor_(openUninterrupted(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
  if (descriptor_ < 0) throw systemError(errno, path, "opening for reading");
  struct stat status {};
  const int failed = ::fstat(descriptor_, &status) != 0 ? errno : S_ISDIR(status.st_mode) ? EISDIR : 0;
  const bool stream = S_ISFIFO(status.st_mode) || S_ISCHR(status.st_mode) || S_ISSOCK(status.st_mode);
  if (failed != 0 || stream) ::close(descriptor_);
  if (failed != 0) throw systemError(failed, path, "opening for reading");
  if (stream)
    throw Error(ErrorCode::kUnsupported, path, "",
                "is a pipe or a device, which cannot be read at an offset; save it as a file first");
  size_ = static_cast<std::uint64_t>(status.st_size);
}

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

File::File(File&& other) noexcept
    : path_(std::move(other.path_)), descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_) {}

std::size_t File::readSomeAt(std::uint64_t offset, std::span<std::byte> out) const {
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t got = ::pread(descriptor_, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw systemError(errno, path_, "reading at byte " + std::to_string(offset + done));
    if (got == 0) break;
    done += static_cast<std::size_t>(got);
    countWork();
  }
  // An early end of file is an error: a caller would take it for the end of the data and lose the rest.
  if (done < out.size() && offset + done < size_) {
    throw Error(ErrorCode::kIo, path_, "byte " + std::to_string(offset + done),
                "the file ends here, but it had " + std::to_string(size_) +
                    " bytes when it was opened; it was cut or is being written by another program");
  }
  return done;
}

void File::readAt(std::uint64_t offset, std::span<std::byte> out) const {
  const std::size_t got = readSomeAt(offset, out);
  if (got < out.size()) {
    throw Error(ErrorCode::kFormat, path_, "byte " + std::to_string(offset + got),
                "the file ends here, but " + std::to_string(out.size() - got) + " more bytes are expected");
  }
}

std::vector<std::byte> readFile(const fs::path& path, std::uint64_t limit_bytes) {
  const File file(path);
  if (file.size() > limit_bytes) {
    throw Error(ErrorCode::kFormat, path, "",
                "has at most " + std::to_string(limit_bytes) + " bytes (found " + std::to_string(file.size()) + ")");
  }
  std::vector<std::byte> data(file.size());
  file.readAt(0, data);
  return data;
}

std::string readTextFile(const fs::path& path, std::uint64_t limit_bytes) {
  const std::vector<std::byte> data = readFile(path, limit_bytes);
  return std::string(reinterpret_cast<const char*>(data.data()), data.size());
}

std::string extensionOf(const fs::path& path) { return lowered(path.extension().string()); }

fs::path temporaryFolder() {
  std::error_code error;
  fs::path out = fs::temp_directory_path(error);
  if (!error) return out;
  const char* const named = std::getenv("TMPDIR");
  throw Error(ErrorCode::kNotFound, "TMPDIR", "",
              fmt::format("there is no folder for temporary files (found '{}'); name a folder that exists",
                          named != nullptr ? named : ""));
}

fs::path behindLinks(const fs::path& path) {
  requireWholeName(path);
  fs::path out = path;
  for (int i = 0; i < kMostLinks; ++i) {
    std::optional<fs::path> next = behindLink(out);
    if (!next) return out;
    out = std::move(*next);
  }
  throw systemError(ELOOP, path, "following its links");
}

bool FileNames::add(const fs::path& path) {
  const fs::path place = behindLinks(path), named = place.parent_path();
  auto folder = folders_.find(named);
  if (folder == folders_.end()) {
    std::error_code unknown;
    const fs::path absolute = fs::absolute(named.empty() ? "." : named, unknown),
                   whole = unknown ? named : fs::weakly_canonical(absolute, unknown);
    folder = folders_.emplace(named, unknown ? named : whole).first;
  }
  return names_.insert((folder->second / place.filename()).string()).second;
}

bool isWrittenInPlace(const fs::path& path) {
  std::error_code unknown;
  const fs::file_status status = fs::status(path, unknown);
  return fs::is_character_file(status) || descriptorNamed(path);
}

FileSystem& FileSystem::real() {
  static FileSystem instance;
  return instance;
}

void FileSystem::writeAtomic(const fs::path& path, std::span<const std::byte> data) {
  if (isWrittenInPlace(path)) return writeFile(path, data, WritePolicy::kUnsynced);
  replace(path, [&](const fs::path& temporary) { writeFile(temporary, data, WritePolicy::kSynced); });
}

void FileSystem::writeAtomic(const fs::path& path, std::string_view text) { writeAtomic(path, bytesOf(text)); }

void FileSystem::writeOwn(const fs::path& path, std::span<const std::byte> data, WritePolicy policy) {
  writeOwn(path, [&](const fs::path& temporary) { writeFile(temporary, data, policy); });
}

void FileSystem::writeOwn(const fs::path& path, std::string_view text) { writeOwn(path, bytesOf(text)); }

void FileSystem::writeOwn(const fs::path& path, const std::function<void(const fs::path&)>& write) {
  requireWholeName(path);
  const fs::path temporary = path.string() + ".tmp";
  try {
    write(temporary);
    rename(temporary, path);
  } catch (...) {
    ::unlink(temporary.c_str());  // does not remove a directory of this name
    throw;
  }
}

void FileSystem::replace(const fs::path& path, const std::function<void(const fs::path&)>& make) {
  const fs::path place = behindLinks(path);
  const TemporaryFile temporary(place);
  try {
    make(temporary.path());
  } catch (const Error& error) {
    throw temporary.named(error);
  }
  rename(temporary.path(), place);
}

void FileSystem::renameInSteps(const fs::path& from, const fs::path& to, const fs::path& old) {
  std::error_code ignored;
  if (!old.empty()) rename(to, old);
  try {
    rename(from, to);
    // Both names must be on the disk before the old folder is removed.
    syncAll(to);
  } catch (...) {
    if (!fs::exists(from, ignored)) fs::rename(to, from, ignored);
    if (!old.empty()) fs::rename(old, to, ignored);
    throw;
  }
}

void FileSystem::requirePlaceFor(const fs::path& path) {
  if (const std::optional<int> open = descriptorNamed(path)) {
    const int how = ::fcntl(*open, F_GETFL);
    if (how < 0 || (how & O_ACCMODE) == O_RDONLY) throw systemError(how < 0 ? errno : EBADF, path, "writing to it");
  }
  if (isWrittenInPlace(path)) return;
  std::error_code unknown;
  const fs::file_status there = fs::status(path, unknown);
  if (fs::is_directory(there)) throw Error(ErrorCode::kIo, path, "", "is a directory; name a file");
  // A pipe would block until a reader opens it; the name of a disk must not become a file.
  if (fs::exists(there) && !fs::is_regular_file(there))
    throw Error(ErrorCode::kUsage, path, "",
                fmt::format("is {}; name a file", fs::is_fifo(there)     ? "a named pipe"
                                                  : fs::is_socket(there) ? "a socket"
                                                                         : "a disk"));
  const fs::path place = behindLinks(path);
  const fs::path directory = place.has_parent_path() ? place.parent_path() : ".";
  requireFolderOf(place, path);
  try {
    makeScratch(directory);
  } catch (const Error& error) {
    throw renamed(error, directory, path);
  }
  const long most = ::pathconf(directory.c_str(), _PC_NAME_MAX);
  const auto bytes = static_cast<long>(place.filename().native().size()) + TemporaryFile::kLongerBytes;
  if (most > 0 && bytes > most) {
    throw Error(ErrorCode::kIo, path, "",
                fmt::format("its name is {} {} too long: a temporary name beside it needs {} more; shorten the name",
                            bytes - most, bytes - most == 1 ? "byte" : "bytes",
                            bytes - static_cast<long>(place.filename().native().size())));
  }
  struct stat of_file, of_directory;
  if (::geteuid() == 0 || ::stat(place.c_str(), &of_file) != 0 || ::stat(directory.c_str(), &of_directory) != 0) return;
  if ((of_directory.st_mode & S_ISVTX) != 0 && of_file.st_uid != ::geteuid() && of_directory.st_uid != ::geteuid())
    throw Error(ErrorCode::kIo, path, "",
                "belongs to another user, who alone may replace it in this directory; name another file");
}

void FileSystem::requirePlaceToRename(const fs::path& path) {
  if (isWrittenInPlace(path)) throw Error(ErrorCode::kUsage, path, "", "is a device or an open file; name a file");
  requirePlaceFor(path);
}

void FileSystem::makeDirectories(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw systemError(error.value(), path, "making the directory");
}

void FileSystem::writeFile(const fs::path& path, std::span<const std::byte> data, WritePolicy policy) {
  Descriptor file(openToWrite(path));
  if (file.get() < 0) throw systemError(errno, path, "creating the file");
  const std::size_t done = policy == WritePolicy::kPastCache ? writePastCache(file.get(), data) : 0;
  // A pipe has no offsets.
  writeAll(file.get(), path, data.subspan(done), done > 0 ? std::optional<std::uint64_t>(done) : std::nullopt);
  if (policy == WritePolicy::kSynced && uninterrupted([&] { return ::fsync(file.get()); }) != 0)
    throw systemError(errno, path, "syncing to disk");
  // Small files are cheaper to write together. Not every file system can begin early; `syncAll` reports a failing disk.
  constexpr std::size_t kWorthBeginning = 1 << 20;
  if (policy == WritePolicy::kBegun && data.size() >= kWorthBeginning)
    ::sync_file_range(file.get(), 0, 0, SYNC_FILE_RANGE_WRITE);
  if (file.close() != 0) throw systemError(errno, path, "closing after writing");
}

void FileSystem::appendFile(const fs::path& path, std::span<const std::byte> data) {
  Descriptor file(openToAppend(path));
  if (file.get() < 0) throw systemError(errno, path, "opening the file");
  writeAll(file.get(), path, data);
  if (file.close() != 0) throw systemError(errno, path, "closing after writing");
}

void FileSystem::rename(const fs::path& from, const fs::path& to) {
  requireWholeName(to);
  if (::rename(from.c_str(), to.c_str()) != 0) throw systemError(errno, to, "renaming into place");
}

bool FileSystem::exchange(const fs::path& a, const fs::path& b) {
  if (::renameat2(AT_FDCWD, a.c_str(), AT_FDCWD, b.c_str(), RENAME_EXCHANGE) == 0) return true;
  // EPERM: a sandbox that refuses calls it does not list. Steps that need no exchange report a real lack of rights.
  if (errno == EINVAL || errno == ENOSYS || errno == EOPNOTSUPP || errno == EPERM) return false;
  throw systemError(errno, b, "renaming into place");
}

void FileSystem::syncFile(const fs::path& path) {
  const Descriptor file(openUninterrupted(path, O_RDONLY | O_CLOEXEC));
  if (file.get() < 0) throw systemError(errno, path, "opening the file");
  if (uninterrupted([&] { return ::fsync(file.get()); }) != 0) throw systemError(errno, path, "syncing to disk");
}

void FileSystem::syncAll(const fs::path& path) {
  const Descriptor directory(openUninterrupted(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.get() < 0) throw systemError(errno, path, "opening the directory");
  if (uninterrupted([&] { return ::syncfs(directory.get()); }) != 0) throw systemError(errno, path, "syncing to disk");
}

void FileSystem::removeAll(const fs::path& path) {
  requireWholeName(path);
  std::error_code error;
  // A second walk removes entries that a failing call left behind.
  for (int walks = 0; walks == 0 || (error && walks < 2); ++walks) {
    do {
      fs::remove_all(path, error);
    } while (error == std::errc::interrupted);
  }
  if (error) throw systemError(error.value(), path, "removing");
}

File FileSystem::makeScratch(const fs::path& directory) {
  // A process that ends between the two calls leaves this name, which an unfinished store may hold.
  constexpr std::string_view kSuffix = ".tmp";
  std::string name;
  // A failed call changes the name, and the next call needs the pattern again.
  File file(directory, uninterrupted([&] {
              name = (directory / "scratch_XXXXXX").string() + std::string(kSuffix);
              return ::mkostemps(name.data(), static_cast<int>(kSuffix.size()), O_CLOEXEC);
            }));
  if (file.descriptor_ < 0 || ::unlink(name.c_str()) != 0) throw systemError(errno, directory, "making a scratch file");
  return file;
}

File FileSystem::openToWriteAt(const fs::path& path) {
  File file(path, openUninterrupted(path, O_RDWR | O_NOFOLLOW | O_CLOEXEC));
  if (file.descriptor_ < 0) throw systemError(errno, path, "opening for writing");
  return file;
}

void FileSystem::writeAt(const File& scratch, std::uint64_t offset, std::span<const std::byte> data) {
  writeAll(scratch.descriptor_, scratch.path_, data, offset);
}

}  // namespace kiln
