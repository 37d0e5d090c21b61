// A disk that copies a folder before each rename, as a process leaves the folder that is killed there.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/file/file.h"

namespace kiln::test {

class SnapshotDisk : public FileSystem {
 public:
  /// The copies are the folders 0, 1, … of `copies`, which lies outside `folder`.
  SnapshotDisk(const std::filesystem::path& folder, const std::filesystem::path& copies)
      : folder_(folder), copies_(copies) {}

  const std::vector<std::filesystem::path>& snapshots() const { return snapshots_; }
  void rename(const std::filesystem::path& from, const std::filesystem::path& to) override {
    namespace fs = std::filesystem;
    const fs::path copy = copies_ / std::to_string(snapshots_.size());
    fs::create_directories(copy);
    fs::copy(folder_, copy, fs::copy_options::recursive | fs::copy_options::copy_symlinks);
    snapshots_.push_back(copy);
    FileSystem::rename(from, to);
  }
  void syncFile(const std::filesystem::path&) override {}
  void syncAll(const std::filesystem::path&) override {}

 private:
  const std::filesystem::path folder_, copies_;
  std::vector<std::filesystem::path> snapshots_;
};

}  // namespace kiln::test
