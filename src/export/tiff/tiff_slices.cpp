// A file for each slice. The files are made in a folder of their own and get their names when all are whole. So a part
// of a stack is never taken for the whole.
#include "export/tiff/tiff_slices.h"

#include <fmt/format.h>

#include <vector>

#include "base/error.h"
#include "base/file/folder.h"
#include "base/file/path_status.h"
#include "export/output/pending_folder.h"
#include "export/source/numbered_name.h"
#include "export/source/output_place.h"
#include "export/tiff/tiff_pages.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Other slices of the pattern would become a part of the stack.
void refuseOtherSlices(const ExportTarget& target, const NumberedName& names, std::int64_t slices) {
  const ExportInputs inputs(target.store);
  forEachEntry(names.folder().empty() ? "." : names.folder(), [&](const fs::directory_entry& entry) {
    const std::string name = entry.path().filename().string();
    if (!names.numberIn(name)) return Walk::kGoOn;
    if (names.isOther(name, 0, slices))
      throw Error(
          ErrorCode::kExists, entry.path(), "",
          fmt::format("would be taken for a slice of this stack of {}; move it, or name another output", slices));
    requireAbsent(entry.path(), target.overwrite);
    inputs.requireNone(entry.path());
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
        folder_(target.out, "slices", Leftover::kRemove, target.disk) {
    refuseOtherSlices(target, names_, volume.geometry.dims.z);
    folder_.requirePlaces(slicePaths());
  }

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
    folder_.moveOut(slicePaths());
    return {bytes_, {}};
  }

 private:
  std::vector<fs::path> slicePaths() const {
    std::vector<fs::path> out;
    for (std::int64_t z = 0; z < volumes_.front().geometry.dims.z; ++z) out.push_back(names_.path(z));
    return out;
  }
  std::uint64_t sliceBytes() const {
    const ExportedVolume& volume = volumes_.front();
    return static_cast<std::uint64_t>(volume.geometry.dims.x * volume.geometry.dims.y) * sizeOf(volume.type);
  }

  const std::vector<ExportedVolume> volumes_;
  const NumberedName names_;
  const TiffPages pages_;
  FileSystem& disk_;
  PendingFolder folder_;
  std::uint64_t bytes_ = 0;
};

}  // namespace

std::unique_ptr<VolumeWriter> tiffSlicesWriter(const ExportTarget& target, const ExportedVolume& volume) {
  const fs::path first = NumberedName(target.out).path(0);
  requireFolderOf(first, target.out);
  requireOutsideStores(first);
  return std::make_unique<TiffSlicesWriter>(volume, target);
}

}  // namespace kiln
