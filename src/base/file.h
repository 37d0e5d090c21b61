// Files as Kiln uses them: read whole or at an offset, and written so that a reader sees all of a file or none of it.
// Every write to a store goes through `FileSystem`, so that a test can make the n-th one fail.
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

  /// Fills `out` from `offset`. throws: Error kFormat where the file ends before `out` is full, kIo.
  void readAt(std::uint64_t offset, std::span<std::byte> out) const;
  /// Up to `out.size()` bytes from `offset`; returns how many there were. throws: Error kIo.
  std::size_t readSomeAt(std::uint64_t offset, std::span<std::byte> out) const;

 private:
  friend class FileSystem;
  File(std::filesystem::path path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}

  std::filesystem::path path_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

/// The whole of a file. throws: Error kNotFound, kIo, kFormat where it is larger than `limit_bytes`.
std::vector<std::byte> readFile(const std::filesystem::path& path, std::uint64_t limit_bytes = UINT64_MAX);
std::string readTextFile(const std::filesystem::path& path, std::uint64_t limit_bytes = UINT64_MAX);

inline std::span<const std::byte> bytesOf(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

/// A name's ending in small letters, with its dot: kinds of files are told by it.
std::string extensionOf(const std::filesystem::path& path);

/// What a name leads to: of a link, and of a link to one, what it is a link to, be it there or not; of others itself.
/// So that a picture is put where a link says, and the link stays. throws: Error kIo where another user made a link.
std::filesystem::path behindLinks(const std::filesystem::path& path);
/// Whether what has this name is written to as it is, never replaced: a device such as /dev/null, or a file that is
/// named by who has it open, as /dev/stdout is.
bool isWrittenInPlace(const std::filesystem::path& path);

/// Files by their names, of which several may be one's: by links, and of folders by other spellings.
class FileNames {
 public:
  /// False where the file is among them already, be it there or not.
  bool add(const std::filesystem::path& path);

 private:
  std::map<std::filesystem::path, std::filesystem::path> folders_;  // as they are named, and as they are
  std::unordered_set<std::string> names_;
};

/// What is true of a file when the call that writes it returns.
enum class WriteMode {
  kSynced,     // it is on its disk
  kUnsynced,   // it is there for every reader; bringing it onto the disk is left to a later `syncAll`
  kPastCache,  // as kUnsynced, but where the file system allows it, its bytes took no room in the page cache: for more
               // bytes than that has room for, which nobody reads soon
};

/// The changes Kiln makes to a disk. Tests derive from it to fail at the n-th call (tests/support).
class FileSystem {
 public:
  virtual ~FileSystem() = default;
  /// The machine's own.
  static FileSystem& real();

  /// As `replace`; a device or an open file (isWrittenInPlace) is written to directly. throws: Error kNoSpace, kIo.
  void writeAtomic(const std::filesystem::path& path, std::span<const std::byte> data);
  void writeAtomic(const std::filesystem::path& path, std::string_view text);
  /// The same in a directory of Kiln's own, such as a store's, where one process writes at a time: the name beside is
  /// always `path` and `.tmp`, so that who goes on after a kill replaces what that left.
  void writeOwn(const std::filesystem::path& path, std::span<const std::byte> data,
                WriteMode mode = WriteMode::kSynced);
  void writeOwn(const std::filesystem::path& path, std::string_view text);
  /// The same of a file that write(temporary) writes piece by piece.
  void writeOwn(const std::filesystem::path& path, const std::function<void(const std::filesystem::path&)>& write);
  /// Calls make(temporary), which writes a TemporaryFile beside `path`, and renames that file to `path`: a reader sees
  /// the old file or the new file, never a part. A link stays, and its target is replaced. On failure the temporary
  /// file is removed. throws: what `make` throws, Error kIo.
  void replace(const std::filesystem::path& path, const std::function<void(const std::filesystem::path&)>& make);

  /// Before hours of work whose result goes there: that a file of this name can be made. throws: Error kNotFound where
  /// there is no such directory, kIo where a directory has the name, where nothing can be made beside it, where it is
  /// too long for that, or another user's who alone may replace it; kNoSpace; kUsage where a pipe, a socket or a disk
  /// has the name. What isWrittenInPlace is not asked.
  void requirePlaceFor(const std::filesystem::path& path);

  /// The same for what is made piece by piece and then gets its name. throws: as that; kUsage also where the name is
  /// of what isWrittenInPlace.
  void requirePlaceToRename(const std::filesystem::path& path);

  virtual void makeDirectories(const std::filesystem::path& path);
  /// Makes a file of `data`. A link or another user's file of that name is replaced and never written through.
  virtual void writeFile(const std::filesystem::path& path, std::span<const std::byte> data, WriteMode mode);
  /// Adds `data` to the end of a file, which is made where it is not there. A crash may leave a part of it.
  virtual void appendFile(const std::filesystem::path& path, std::span<const std::byte> data);
  virtual void rename(const std::filesystem::path& from, const std::filesystem::path& to);
  /// Exchanges two names in one step, so that a reader finds something under each at any time. Returns false where the
  /// file system cannot. throws: Error kIo.
  virtual bool exchange(const std::filesystem::path& a, const std::filesystem::path& b);
  /// Brings one file, whoever wrote it, onto its disk.
  virtual void syncFile(const std::filesystem::path& path);
  /// Brings everything written to the file system that holds `path`, and every new name on it, onto its disk. cost: one
  /// wait, where a sync of each of thousands of files would be thousands.
  virtual void syncAll(const std::filesystem::path& path);
  virtual void removeAll(const std::filesystem::path& path);

  /// A new and empty file on the disk of `directory`, for `writeAt` and reading. It has no name any more, so nothing of
  /// it is left once it is closed, however the process ends. throws: Error kNoSpace, kIo, naming `directory`.
  virtual File makeScratch(const std::filesystem::path& directory);
  /// Writes `data` from `offset` of a file that `makeScratch` made. thread: safe for bytes that no other call touches.
  virtual void writeAt(const File& scratch, std::uint64_t offset, std::span<const std::byte> data);
};

}  // namespace kiln
