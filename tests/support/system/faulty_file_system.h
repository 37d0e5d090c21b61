// A file system whose n-th change fails. Repeating a test for every n finds writers that ignore errors. Source:
// leveldb's db/fault_injection_test.cc.
#pragma once

#include <cerrno>
#include <cstdint>
#include <limits>
#include <mutex>
#include <utility>
#include <vector>

#include "base/file/file.h"

namespace kiln::test {

struct DiskFault {
  /// Number of successful changes before the failing change; the default never fails.
  std::uint64_t after_calls = std::numeric_limits<std::uint64_t>::max();
  int error_number = ENOSPC;
  /// A failing write leaves the first half of its bytes behind.
  bool torn_write = false;
  /// The process is as good as dead from the fault on: every later change fails, too.
  bool crash = false;
};

/// Forwards changes to the real disk until the fault. thread: safe; with several threads, chance selects the failing
/// thread.
class FaultyFileSystem : public FileSystem {
 public:
  explicit FaultyFileSystem(const DiskFault& fault = {}) : fault_(fault) {}

  /// Number of changes so far, including failed changes. A run without a fault gives a test the number of changes.
  std::uint64_t calls() const;
  /// True once the fault has happened.
  bool failed() const { return calls() > fault_.after_calls; }

  /// Restores the files that a power cut at the fault would have left and that the process has since removed: the half
  /// of a torn write, or the whole temporary file before its rename. Call it after a crash, before inspecting the disk.
  void leaveWreckage();

  void makeDirectories(const std::filesystem::path& path) override;
  void writeFile(const std::filesystem::path& path, std::span<const std::byte> data, WritePolicy policy) override;
  void appendFile(const std::filesystem::path& path, std::span<const std::byte> data) override;
  void rename(const std::filesystem::path& from, const std::filesystem::path& to) override;
  bool exchange(const std::filesystem::path& a, const std::filesystem::path& b) override;
  void syncFile(const std::filesystem::path& path) override;
  void syncAll(const std::filesystem::path& path) override;
  void removeAll(const std::filesystem::path& path) override;
  File makeScratch(const std::filesystem::path& directory) override;
  void writeAt(const File& scratch, std::uint64_t offset, std::span<const std::byte> data) override;

 private:
  enum class Outcome { kWorks, kFails, kDead };
  Outcome nextCall();
  void failIfTold(const std::filesystem::path& path, const char* doing);
  [[noreturn]] void fail(const std::filesystem::path& path, const char* doing) const;

  const DiskFault fault_;
  mutable std::mutex mutex_;
  std::uint64_t calls_ = 0;
  std::vector<std::pair<std::filesystem::path, std::vector<std::byte>>> wreckage_;
};

}  // namespace kiln::test
