// Names of files that differ in a number: a run of # in the name is its place.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace kiln {

class NumberedName {
 public:
  static bool isPattern(const std::filesystem::path& path);
  /// The last run of # is the place. requires: isPattern(pattern).
  explicit NumberedName(const std::filesystem::path& pattern);

  const std::filesystem::path& folder() const { return folder_; }
  /// Returns the name of a number, with zeros in front up to the length of the run.
  std::string name(std::int64_t number) const;
  std::filesystem::path path(std::int64_t number) const { return folder_ / name(number); }
  /// Returns the number in a name of the pattern, of any width; nothing for other names.
  std::optional<std::int64_t> numberIn(const std::string& name) const;
  /// True if a name has the pattern, but is the name of no number from `first` up to `end`, which is outside.
  bool isOther(const std::string& name, std::int64_t first, std::int64_t end) const;

 private:
  std::filesystem::path folder_;
  std::string before_, behind_;
  std::size_t width_ = 0;
};

}  // namespace kiln
