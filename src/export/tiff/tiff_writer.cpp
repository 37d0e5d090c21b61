// One file of many pages. The description is ImageJ's; other programs find a page in each directory.
#include "export/linear/linear_writer.h"
#include "export/source/export_formats.h"
#include "export/source/numbered_name.h"
#include "export/source/output_place.h"
#include "export/tiff/tiff_pages.h"
#include "export/tiff/tiff_slices.h"

namespace kiln {
namespace {

class TiffWriter : public VolumeWriter {
 public:
  TiffWriter(const ExportedVolume& volume, const ExportTarget& target)
      : volumes_{volume}, pages_(volume, volume.geometry.dims.z), file_(target.out, target.disk) {
    file_.append(pages_.head());
  }

  const std::vector<ExportedVolume>& volumes() const override { return volumes_; }
  BoxRule boxes(const ExportedVolume&) const override { return {BoxRule::Kind::kRows, {}}; }
  std::uint64_t workBytes(std::uint64_t, unsigned) const override { return kDirectoriesAtOnce; }
  void write(const ExportedVolume& volume, const VoxelBox& box, std::span<const std::byte> voxels) override {
    writeRows(file_, pages_.head().size(), volume, box, voxels);
  }
  WrittenFiles finish() override {
    std::vector<std::byte> directories(file_.size() % 2);  // they begin at an even byte
    for (std::int64_t page = 1; page < volumes_.front().geometry.dims.z; ++page) {
      const std::vector<std::byte> directory = pages_.directory(page);
      directories.insert(directories.end(), directory.begin(), directory.end());
      if (directories.size() < kDirectoriesAtOnce / 4) continue;
      file_.append(directories);
      directories.clear();
    }
    file_.append(directories);
    file_.sync();
    file_.publish();
    return {file_.size(), {}};
  }

 private:
  static constexpr std::uint64_t kDirectoriesAtOnce = 256 << 10;
  const std::vector<ExportedVolume> volumes_;
  const TiffPages pages_;
  PendingFile file_;
};

void notePlaceOfTiff(const VolumeGeometry& geometry, ExportNotes& notes) {
  if (isPlacedBySpacing(geometry) && geometry.frame == PatientFrame::kUnknown) return;
  notes.push_back("TIFF holds spacing and unit, and no origin, directions and patient frame");
}

}  // namespace

std::unique_ptr<VolumeWriter> openTiffWriter(const ExportTarget& target, const ExportedVolume& volume,
                                             ExportNotes& notes) {
  notePlaceOfTiff(volume.geometry, notes);
  if (NumberedName::isPattern(target.out)) return tiffSlicesWriter(target, volume);
  requirePlace(target.store, target.out, target.overwrite, target.disk);
  return std::make_unique<TiffWriter>(volume, target);
}

}  // namespace kiln
