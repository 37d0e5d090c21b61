// The files that a command is going to write, so that none of them is a file that the command reads: by device and
// inode, whatever links, hard links or spellings lead to it. Nor is a file put into the folder of a store.
#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>
#include <vector>

namespace kiln::tool {

class OutputFiles {
 public:
  /// `option` is what named the file, for the message, such as "--stats". A name without a regular file behind it, as
  /// of a device, is no file that could be lost. throws: Error kUsage where the file would be in a store's folder.
  void add(const std::filesystem::path& path, const std::string& option = "-o");

  /// Call this for each file or folder that is read, before anything is written. Files in folders of a folder count,
  /// too. throws: Error kUsage, naming the option and the output, where an output is the file, or is in the folder or
  /// linked to a file in it. cost: files of a folder are looked at where an output is in it or has several links.
  void requireNone(const std::filesystem::path& read) const;
  /// Checks single files and ignores folders among them: slices of a folder are files of their own.
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
  std::set<std::filesystem::path> folders_;  // in which the outputs are
};

}  // namespace kiln::tool
