#include "faulty_file_system.h"

#include "base/error.h"

namespace kiln::test {
namespace fs = std::filesystem;

std::uint64_t FaultyFileSystem::calls() const {
  const std::lock_guard lock(mutex_);
  return calls_;
}

FaultyFileSystem::Outcome FaultyFileSystem::nextCall() {
  const std::lock_guard lock(mutex_);
  const std::uint64_t call = calls_++;
  if (call == fault_.after_calls) return Outcome::kFails;
  return call > fault_.after_calls && fault_.crash ? Outcome::kDead : Outcome::kWorks;
}

void FaultyFileSystem::fail(const fs::path& path, const char* doing) const {
  throw systemError(fault_.error_number, path, doing);
}

void FaultyFileSystem::failIfTold(const fs::path& path, const char* doing) {
  if (nextCall() != Outcome::kWorks) fail(path, doing);
}

void FaultyFileSystem::makeDirectories(const fs::path& path) {
  failIfTold(path, "making the directory (injected)");
  FileSystem::makeDirectories(path);
}

void FaultyFileSystem::writeFile(const fs::path& path, std::span<const std::byte> data, WritePolicy policy) {
  const Outcome outcome = nextCall();
  if (outcome == Outcome::kWorks) return FileSystem::writeFile(path, data, policy);
  if (outcome == Outcome::kFails && fault_.torn_write) {
    const auto half = data.first(data.size() / 2);
    FileSystem::writeFile(path, half, WritePolicy::kUnsynced);
    const std::lock_guard lock(mutex_);
    wreckage_.emplace_back(path, std::vector<std::byte>(half.begin(), half.end()));
  }
  fail(path, "writing (injected)");
}

void FaultyFileSystem::appendFile(const fs::path& path, std::span<const std::byte> data) {
  const Outcome outcome = nextCall();
  if (outcome == Outcome::kWorks) return FileSystem::appendFile(path, data);
  if (outcome == Outcome::kFails && fault_.torn_write) FileSystem::appendFile(path, data.first(data.size() / 2));
  fail(path, "appending (injected)");
}

void FaultyFileSystem::rename(const fs::path& from, const fs::path& to) {
  const Outcome outcome = nextCall();
  if (outcome == Outcome::kWorks) return FileSystem::rename(from, to);
  if (outcome == Outcome::kFails && fs::is_regular_file(from)) {
    std::vector<std::byte> content = readFile(from);
    const std::lock_guard lock(mutex_);
    wreckage_.emplace_back(from, std::move(content));
  }
  fail(to, "renaming into place (injected)");
}

bool FaultyFileSystem::exchange(const fs::path& a, const fs::path& b) {
  failIfTold(b, "exchanging names (injected)");
  return FileSystem::exchange(a, b);
}

void FaultyFileSystem::syncFile(const fs::path& path) {
  failIfTold(path, "syncing the file (injected)");
  FileSystem::syncFile(path);
}

void FaultyFileSystem::syncAll(const fs::path& path) {
  failIfTold(path, "syncing the directory (injected)");
  FileSystem::syncAll(path);
}

void FaultyFileSystem::removeAll(const fs::path& path) {
  failIfTold(path, "removing (injected)");
  FileSystem::removeAll(path);
}

File FaultyFileSystem::makeScratch(const fs::path& directory) {
  failIfTold(directory, "making a scratch file (injected)");
  return FileSystem::makeScratch(directory);
}

void FaultyFileSystem::writeAt(const File& scratch, std::uint64_t offset, std::span<const std::byte> data) {
  failIfTold(scratch.path(), "writing to a scratch file (injected)");
  FileSystem::writeAt(scratch, offset, data);
}

void FaultyFileSystem::leaveWreckage() {
  const std::lock_guard lock(mutex_);
  for (const auto& [path, content] : wreckage_) {
    if (fs::is_directory(path.parent_path())) FileSystem::writeFile(path, content, WritePolicy::kUnsynced);
  }
}

}  // namespace kiln::test
