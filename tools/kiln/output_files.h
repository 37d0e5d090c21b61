// The outputs of a command, checked against its inputs by device and inode, so that links and spellings of a path do
// not matter. No output may lie in the folder of a store.
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "base/progress.h"
#include "image/image.h"

namespace kiln::tool {

class OutputFiles {
 public:
  /// Adds an output; `option`, such as "--stats", names it in errors. A path without a regular file, as a device,
  /// cannot lose data and passes. If the output is standard output, the command's text goes to standard error. throws:
  /// Error kUsage if the file would be in a store's folder.
  void add(const std::filesystem::path& path, const std::string& option = "-o");

  /// Checks an input: a file, or a folder with all files below it. Call before anything is written. throws: Error
  /// kUsage, naming option and output, if an output is the input, lies in the input folder, or is linked to a file in
  /// it.
  /// cost: reads the folder only if an output lies in it or has several links.
  void requireNone(const std::filesystem::path& read) const;
  /// Checks single files and skips folders: the slices of a folder are listed as files.
  void requireNoneOf(const std::vector<std::filesystem::path>& read) const;

 private:
  struct Output {
    std::filesystem::path path;
    std::string option;
    std::uint64_t device, inode;
    bool linked;
  };
  void requireNotThis(const std::filesystem::path& file) const;
  bool mayBeIn(const std::filesystem::path& folder) const;
  std::vector<Output> outputs_;
  std::set<std::filesystem::path> folders_;  // the folders of the outputs
};

/// Notes that a JPEG has no transparency, if the path is a JPEG's and the picture lets something through.
void noteBlack(const Image& image, const std::filesystem::path& path, Progress& progress);

}  // namespace kiln::tool
