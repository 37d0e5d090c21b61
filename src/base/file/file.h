// Reads files, whole or at an offset, and replaces files atomically: a reader sees a whole file or none.
// Every write to a store goes through `FileSystem`, so a test can make the n-th write fail.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <unordered_set>
#include <utility>
#include <vector>

namespace kiln {

/// A file open for reading. thread: `readAt` may be called from several threads at once.
class File {
 public:
  /// throws: Error kNotFound, kIo; kIo for a directory.
  explicit File(const std::filesystem::path& path);
  ~File();
  File(File&& other) noexcept;
  File& operator=(File&&) = delete;

  const std::filesystem::path& path() const { return path_; }
  /// unit: bytes.
  std::uint64_t size() const { return size_; }

  /// Fills `out` from `offset`. throws: Error kFormat if the file ends before `out` is full, kIo.
  void readAt(std::uint64_t offset, std::span<std::byte> out) const;
  /// Reads up to `out.size()` bytes from `offset` and returns the number of bytes read. throws: Error kIo.
  std::size_t readSomeAt(std::uint64_t offset, std::span<std::byte> out) const;

 private:
  friend class FileSystem;
  File(std::filesystem::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// Returns the whole file. throws: Error kNotFound, kIo, kFormat if the file is larger than `limit_bytes`.
std::vector<std::byte> readFile(const std::filesystem::path& path, std::uint64_t limit_bytes = UINT64_MAX);
std::string readTextFile(const std::filesystem::path& path, std::uint64_t limit_bytes = UINT64_MAX);

inline std::span<const std::byte> bytesOf(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

/// Returns the extension of a file name in small letters, with the dot. The extension decides the kind of file.
std::string extensionOf(const std::filesystem::path& path);
/// Returns the folder of temporary files. throws: Error kNotFound naming TMPDIR.
std::filesystem::path temporaryFolder();

/// Follows a link, and a link to a link, to the last target, existing or not. Any path without a link is returned
/// unchanged. Writing to the target keeps the link. throws: Error kIo if another user made a link or links lead to one
/// another; kUsage if the name has a NUL character.
std::filesystem::path behindLinks(const std::filesystem::path& path);
/// True if writing to `path` must not replace the file: a device such as /dev/null, or an open file of this process,
/// such as /dev/stdout.
bool isWrittenInPlace(const std::filesystem::path& path);

/// A set of files. Several names of one file (by links, or by other spellings of a folder) are one element.
class FileNames {
 public:
  /// Adds a file, existing or not. Returns false if the set already holds the file.
  bool add(const std::filesystem::path& path);

 private:
  // folder as spelled by the caller -> resolved folder
  std::map<std::filesystem::path, std::filesystem::path> folders_;
  std::unordered_set<std::string> names_;
};

/// State of a written file when the write call returns.
enum class WritePolicy {
  kSynced,    // the bytes are on the disk
  kUnsynced,  // every reader sees the bytes; a later `syncAll` brings them onto the disk
  kBegun,  // as kUnsynced, and the disk begins to write a large file at once: `syncAll` waits for less, the writer for
           // a full queue
  kPastCache,  // as kUnsynced, but past the page cache if the file system can; for large data not read soon
};

/// The changes that Kiln makes to a disk. Tests derive from this class to fail at the n-th call (tests/support).
class FileSystem {
 public:
  virtual ~FileSystem() = default;
  /// The file system of the operating system.
  static FileSystem& real();

  /// Writes a file by `replace`; a device or an open file (isWrittenInPlace) is written directly. throws: Error
  /// kNoSpace, kIo.
  void writeAtomic(const std::filesystem::path& path, std::span<const std::byte> data);
  void writeAtomic(const std::filesystem::path& path, std::string_view text);
  /// Writes a file atomically in a directory that only one Kiln process writes to, such as a store. The temporary name
  /// is always `path` plus `.tmp`, so a process that resumes after a kill replaces the leftover file.
  void writeOwn(const std::filesystem::path& path, std::span<const std::byte> data,
                WritePolicy policy = WritePolicy::kSynced);
  void writeOwn(const std::filesystem::path& path, std::string_view text);
  /// Calls write(temporary), which makes the file, then renames the file to `path`, as the other overloads do.
  void writeOwn(const std::filesystem::path& path, const std::function<void(const std::filesystem::path&)>& write);
  /// Calls make(temporary), which writes a TemporaryFile beside `path`, and renames that file to `path`: a reader sees
  /// the old file or the new file, never a part. If `path` is a link, its target is replaced. On failure the temporary
  /// file is removed. throws: any exception of `make`, Error kIo.
  void replace(const std::filesystem::path& path, const std::function<void(const std::filesystem::path&)>& make);

  /// Checks that a file of this name can be made, before hours of work that end with the file. Skips a path that is
  /// written in place (isWrittenInPlace).
  /// throws: Error
  /// - kNotFound if the directory does not exist;
  /// - kIo if a directory has the name, if no temporary file can be made beside it, if the name is too long for a
  ///   temporary name, or if only another user may replace the file;
  /// - kNoSpace;
  /// - kUsage if a pipe, a socket or a disk has the name.
  void requirePlaceFor(const std::filesystem::path& path);

  /// Checks as requirePlaceFor for an output that is made in pieces and renamed at the end. throws: as requirePlaceFor;
  /// also kUsage for a path that is written in place.
  void requirePlaceToRename(const std::filesystem::path& path);

  virtual void makeDirectories(const std::filesystem::path& path);
  /// Makes a file that holds `data`. Replaces a link or another user's file of this name; never writes through either.
  virtual void writeFile(const std::filesystem::path& path, std::span<const std::byte> data, WritePolicy policy);
  /// Appends `data` to a file and makes the file if there is none. A crash may leave a part of `data`.
  virtual void appendFile(const std::filesystem::path& path, std::span<const std::byte> data);
  virtual void rename(const std::filesystem::path& from, const std::filesystem::path& to);
  /// Exchanges two names in one step: each name leads to a file at any time. Returns false if the file system cannot.
  /// throws: Error kIo.
  virtual bool exchange(const std::filesystem::path& a, const std::filesystem::path& b);
  /// Gives a folder the name `to`, whose folder gets the name `old`, in two steps, where names cannot be exchanged; an
  /// empty `old` if nothing has the name. Both names are on the disk at the end. A failure restores the names, where
  /// the disk allows. throws: Error kIo, kNoSpace.
  void renameInSteps(const std::filesystem::path& from, const std::filesystem::path& to,
                     const std::filesystem::path& old);
  /// Brings one file, written by any process, onto its disk.
  virtual void syncFile(const std::filesystem::path& path);
  /// Brings all written data and all new names on the file system of `path` onto the disk. cost: one wait, instead of
  /// one wait per file.
  virtual void syncAll(const std::filesystem::path& path);
  virtual void removeAll(const std::filesystem::path& path);

  /// Makes a new, empty file on the disk of `directory`, for `writeAt` and reading. The file has no name, so it
  /// disappears when closed, even after a crash. throws: Error kNoSpace, kIo, naming `directory`.
  virtual File makeScratch(const std::filesystem::path& directory);
  /// Opens a file that is there, such as a temporary file, for `writeAt` and reading. throws: Error kNotFound, kIo.
  File openToWriteAt(const std::filesystem::path& path);
  /// Writes `data` at `offset` into a file of `makeScratch` or `openToWriteAt`. thread: safe for bytes that no other
  /// call writes or reads.
  virtual void writeAt(const File& scratch, std::uint64_t offset, std::span<const std::byte> data);
};

}  // namespace kiln
