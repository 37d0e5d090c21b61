#include "convert/resume/source_state.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <optional>
#include <system_error>

#include "base/error.h"
#include "base/file/file.h"
#include "base/file/file_stamp.h"
#include "base/file/folder.h"
#include "base/file/path_status.h"
#include "base/hash.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kHashDigits = 32;

std::vector<fs::path> regularFiles(const std::vector<fs::path>& files) {
  std::vector<fs::path> out;
  for (const fs::path& file : files) {
    if (!isThere(file)) continue;
    std::error_code error;
    if (fs::is_regular_file(file, error)) out.push_back(file);
    if (error) throw systemError(error.value(), file, "looking at the source");
  }
  return out;
}

// A sum of hashes, which does not depend on the order of files.
class TreeSum {
 public:
  void add(std::string_view text) {
    const Hash128 hash = hashOf(text);
    for (std::size_t half = 0; half < 2; ++half) {
      std::uint64_t value;
      std::memcpy(&value, hash.bytes.data() + half * sizeof value, sizeof value);
      sum_[half] += value;
    }
    ++count_;
  }
  std::string text() const {
    return count_ == 0 ? "" : fmt::format("{} files {:016x} {:016x}\n", count_, sum_[0], sum_[1]);
  }

 private:
  std::array<std::uint64_t, 2> sum_{};
  std::uint64_t count_ = 0;
};

/// The stamps and the change times of all files of the trees.
struct TreeState {
  std::string stamp, clock;
};

TreeState stateOfTrees(const std::vector<fs::path>& trees) {
  TreeSum stamps, clocks;
  for (const fs::path& tree : trees) {
    const std::size_t own = tree.native().size() - (tree.has_filename() ? 0 : 1);
    forEachEntryBelow(tree, [&](const fs::directory_entry& entry) {
      // A store in the making, and its lock, may lie in the tree.
      if (entry.path().filename().native().find(".kiln") != std::string::npos) return Walk::kPassOver;
      const std::optional<FileStamp> file = stampOfFile(entry.path());
      if (!file) return Walk::kGoOn;
      const std::string name = entry.path().native().substr(own + 1);
      stamps.add(fmt::format("{} {} {}", name, file->bytes, file->written_ns));
      clocks.add(fmt::format("{} {}", name, file->changed_ns));
      return Walk::kGoOn;
    });
  }
  return {stamps.text(), clocks.text()};
}

std::string stampOf(const std::vector<fs::path>& regular, bool named, const TreeState& trees) {
  std::string all = trees.stamp;
  for (const fs::path& file : regular) {
    std::error_code error;
    const std::uintmax_t size = fs::file_size(file, error);
    const fs::file_time_type written = error ? fs::file_time_type() : fs::last_write_time(file, error);
    // A state without a file's time would match no later state, or a wrong one.
    if (error) throw systemError(error.value(), file, "looking at the source");
    // The names of slices give their order; a single file may be moved with its store.
    all += fmt::format("{} {} {}\n", size, written.time_since_epoch().count(), named ? file.filename().string() : "");
  }
  return toHex(hashOf(all));
}

std::int64_t changedNs(const fs::path& file) {
  if (const std::optional<FileStamp> stamp = stampOfFile(file)) return stamp->changed_ns;
  throw Error(ErrorCode::kNotFound, file, "", "was removed, or is no file any more");
}

std::string clockOf(const std::vector<fs::path>& regular, const TreeState& trees) {
  std::string all = trees.clock;
  for (const fs::path& file : regular) all += fmt::format("{}\n", changedNs(file));
  return toHex(hashOf(all));
}

// Appends the hashes of the file's blocks.
void addContent(const fs::path& path, std::uint64_t share_bytes, std::string& all) {
  const File file(path);
  // a page; about the bytes a disk reads in the time of a seek
  const std::uint64_t block = share_bytes < (1u << 20) ? 4096 : 65536;
  const std::uint64_t size = file.size();
  const bool whole = size <= share_bytes;
  const std::uint64_t blocks = whole ? (size + block - 1) / block : share_bytes / block;
  std::vector<std::byte> bytes(block);
  for (std::uint64_t i = 0; i < blocks; ++i) {
    const std::uint64_t offset = whole ? i * block
                                       : static_cast<std::uint64_t>(static_cast<long double>(size - block) * i /
                                                                    static_cast<long double>(blocks - 1));
    const std::size_t got = file.readSomeAt(offset, bytes);
    all += toHex(hashOf(std::span<const std::byte>(bytes).first(got)));
  }
}

std::string contentOf(const std::vector<fs::path>& regular) {
  constexpr std::uint64_t kReadBytes = 64 << 20, kLeastBytes = 2 * 4096;
  std::string all;
  for (const fs::path& file : regular) {
    addContent(file, std::max(kReadBytes / regular.size(), kLeastBytes), all);
  }
  return toHex(hashOf(all));
}

}  // namespace

std::string stateOf(const std::vector<fs::path>& files, const std::vector<fs::path>& trees) {
  const std::vector<fs::path> regular = regularFiles(files);
  if (regular.empty()) return {};
  const TreeState of_trees = stateOfTrees(trees);
  return fmt::format("{}:{}:{}", stampOf(regular, files.size() > 1, of_trees), clockOf(regular, of_trees),
                     contentOf(regular));
}

bool isStateOf(const std::string& state, const std::vector<fs::path>& files, const std::vector<fs::path>& trees) {
  const std::vector<fs::path> regular = regularFiles(files);
  if (regular.empty() || state.empty()) return regular.empty() && state.empty();
  const std::string_view text = state;
  const TreeState of_trees = stateOfTrees(trees);
  if (text.substr(0, kHashDigits) != stampOf(regular, files.size() > 1, of_trees)) return false;
  if (text.size() == kHashDigits) return true;
  if (text.substr(kHashDigits + 1, kHashDigits) == clockOf(regular, of_trees)) return true;
  // The content covers no file of a tree.
  return trees.empty() && text.substr(text.size() - std::min(text.size(), kHashDigits)) == contentOf(regular);
}

std::string portableState(const std::string& state) {
  return state.size() <= 2 * kHashDigits ? state : state.substr(0, kHashDigits) + state.substr(2 * kHashDigits + 1);
}

fs::path lastChanged(const std::vector<fs::path>& files) {
  const std::vector<fs::path> regular = regularFiles(files);
  const auto last = std::max_element(regular.begin(), regular.end(),
                                     [](const fs::path& a, const fs::path& b) { return changedNs(a) < changedNs(b); });
  return last == regular.end() ? files.front() : *last;
}

}  // namespace kiln
