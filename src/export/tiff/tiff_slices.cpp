// A file for each slice. The files are made in a folder of their own and get their names when all are whole, so a part
// of a stack is never taken for the whole.
#include "export/tiff/tiff_slices.h"

#include <fmt/format.h>

#include <limits>
#include <optional>

#include "base/error.h"
#include "base/folder.h"
#include "base/path_status.h"
#include "base/text.h"
#include "export/output/pending_folder.h"
#include "export/tiff/tiff_pages.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// The name of a slice: its number, with zeros in front, in place of the last run of #.
class SliceNames {
 public:
  explicit SliceNames(const fs::path& pattern) : folder_(pattern.parent_path()) {
    const std::string name = pattern.filename().string();
    const std::size_t last = name.find_last_of('#'), first = name.find_last_not_of('#', last) + 1;
    before_ = name.substr(0, first);
    width_ = last + 1 - first;
    behind_ = name.substr(last + 1);
  }
  const fs::path& folder() const { return folder_; }
  std::string name(std::int64_t slice) const { return fmt::format("{}{:0{}}{}", before_, slice, width_, behind_); }
  fs::path path(std::int64_t slice) const { return folder_ / name(slice); }
  /// Returns the number in a name of the pattern, of any width; nothing for other names.
  std::optional<std::int64_t> numberIn(const std::string& name) const {
    if (name.size() <= before_.size() + behind_.size() || !name.starts_with(before_) || !name.ends_with(behind_))
      return std::nullopt;
    const std::string number = name.substr(before_.size(), name.size() - before_.size() - behind_.size());
    if (number.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
    return numberOf<std::int64_t>(number).value_or(std::numeric_limits<std::int64_t>::max());
  }

 private:
  fs::path folder_;
  std::string before_, behind_;
  std::size_t width_ = 0;
};

// Other slices of the pattern would become a part of the stack.
void refuseOtherSlices(const ExportTarget& target, const SliceNames& names, std::int64_t slices) {
  const fs::path folder = names.folder().empty() ? "." : names.folder();
  if (!isFolder(folder))
    throw Error(ErrorCode::kNotFound, target.out, "", "cannot be made: there is no directory " + folder.string());
  forEachEntry(folder, [&](const fs::directory_entry& entry) {
    const std::string name = entry.path().filename().string();
    const std::optional<std::int64_t> number = names.numberIn(name);
    if (!number) return Walk::kGoOn;
    if (*number >= slices || names.name(*number) != name)
      throw Error(
          ErrorCode::kExists, entry.path(), "",
          fmt::format("would be taken for a slice of this stack of {}; move it, or name another output", slices));
    if (!target.overwrite)
      throw Error(ErrorCode::kExists, entry.path(), "", "is there already; name another output or give --overwrite");
    return Walk::kGoOn;
  });
}

class TiffSlicesWriter : public VolumeWriter {
 public:
  TiffSlicesWriter(const ExportedVolume& volume, const ExportTarget& target)
      : volumes_{volume},
        names_(target.out),
        pages_(volume, 1),
        disk_(target.disk),
        folder_(target.out, "slices", Leftover::kRemove, target.disk) {}

  const std::vector<ExportedVolume>& volumes() const override { return volumes_; }
  BoxRule boxes(const ExportedVolume&) const override { return {BoxRule::Kind::kSlices, {}}; }
  std::uint64_t workBytes(std::uint64_t, unsigned) const override { return pages_.head().size() + sliceBytes(); }
  void write(const ExportedVolume& volume, const VoxelBox& box, std::span<const std::byte> voxels) override {
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      std::vector<std::byte> file = pages_.head();
      const auto slice = voxels.subspan(static_cast<std::size_t>(z - box.lo.z) * sliceBytes(), sliceBytes());
      file.insert(file.end(), slice.begin(), slice.end());
      disk_.writeFile(folder_.path() / names_.name(z - volume.box.lo.z), file, WritePolicy::kUnsynced);
      bytes_ += file.size();
    }
  }
  WrittenFiles finish() override {
    folder_.sync();
    std::int64_t named = 0;
    try {
      for (; named < volumes_.front().geometry.dims.z; ++named)
        disk_.rename(folder_.path() / names_.name(named), names_.path(named));
    } catch (...) {
      std::error_code ignored;
      while (named-- > 0) fs::remove(names_.path(named), ignored);
      throw;
    }
    return {bytes_, {}};
  }

 private:
  std::uint64_t sliceBytes() const {
    const ExportedVolume& volume = volumes_.front();
    return static_cast<std::uint64_t>(volume.geometry.dims.x * volume.geometry.dims.y) * sizeOf(volume.type);
  }

  const std::vector<ExportedVolume> volumes_;
  const SliceNames names_;
  const TiffPages pages_;
  FileSystem& disk_;
  PendingFolder folder_;
  std::uint64_t bytes_ = 0;
};

}  // namespace

std::unique_ptr<VolumeWriter> tiffSlicesWriter(const ExportTarget& target, const ExportedVolume& volume) {
  refuseOtherSlices(target, SliceNames(target.out), volume.geometry.dims.z);
  return std::make_unique<TiffSlicesWriter>(volume, target);
}

}  // namespace kiln
