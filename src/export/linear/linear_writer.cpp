#include "export/linear/linear_writer.h"

#include <bit>
#include <optional>
#include <system_error>
#include <utility>

#include "base/file/path_status.h"
#include "base/file/temporary_file.h"
#include "export/output/gzip_output.h"
#include "export/source/output_place.h"

namespace kiln {
namespace {

static_assert(std::endian::native == std::endian::little, "voxels are written in the order of memory");

// The file of a header beside the file of voxels. A crash between the two names leaves voxels without a header, and
// never a header of other voxels.
class HeaderBeside {
 public:
  HeaderBeside(const std::filesystem::path& path, std::span<const std::byte> header, FileSystem& disk)
      : path_(path), disk_(disk), file_(path, disk) {
    file_.append(header);
  }
  void publishAfter(PendingFile& voxels) {
    file_.sync();
    if (!isThere(path_)) {
      voxels.publish();
    } else {
      const std::filesystem::path header = behindLinks(path_);
      const TemporaryFile old(header);
      disk_.rename(header, old.path());
      std::error_code ignored;
      try {
        voxels.publish();
      } catch (...) {
        std::filesystem::rename(old.path(), header, ignored);
        throw;
      }
      std::filesystem::remove(old.path(), ignored);
    }
    file_.publish();
  }
  std::uint64_t size() const { return file_.size(); }

 private:
  const std::filesystem::path path_;
  FileSystem& disk_;
  PendingFile file_;
};

class LinearWriter : public VolumeWriter {
 public:
  LinearWriter(const ExportTarget& target, const ExportedVolume& volume, LinearLayout layout)
      : volumes_{volume},
        layout_(std::move(layout)),
        file_(layout_.voxels_file.empty() ? target.out : layout_.voxels_file, target.disk) {
    if (!layout_.voxels_file.empty()) header_.emplace(target.out, layout_.header, target.disk);
    if (layout_.packing == Packing::kAll) openStream();
    if (header_) return;
    append(layout_.header);
    voxels_begin_ = file_.size();
    if (layout_.packing == Packing::kVoxels) openStream();
  }

  const std::vector<ExportedVolume>& volumes() const override { return volumes_; }
  BoxRule boxes(const ExportedVolume&) const override {
    return {stream_ ? BoxRule::Kind::kSlices : BoxRule::Kind::kRows, {}};
  }
  std::uint64_t workBytes(std::uint64_t, unsigned threads) const override {
    return stream_ ? GzipOutput::bytes(threads) : 0;
  }
  void write(const ExportedVolume& volume, const VoxelBox& box, std::span<const std::byte> voxels) override {
    if (stream_) return stream_->write(voxels);
    writeRows(file_, voxels_begin_, volume, box, voxels);
  }
  WrittenFiles finish() override {
    if (stream_) stream_->finish();
    const std::uint64_t bytes = file_.size() + (header_ ? header_->size() : 0);
    file_.sync();
    if (header_)
      header_->publishAfter(file_);
    else
      file_.publish();
    return {bytes, layout_.lines};
  }

 private:
  void openStream() {
    stream_.emplace([this](std::span<const std::byte> packed) { file_.append(packed); });
  }
  void append(std::span<const std::byte> data) {
    if (stream_)
      stream_->write(data);
    else
      file_.append(data);
  }

  const std::vector<ExportedVolume> volumes_;
  const LinearLayout layout_;
  PendingFile file_;
  std::optional<HeaderBeside> header_;
  std::optional<GzipOutput> stream_;
  std::uint64_t voxels_begin_ = 0;
};

}  // namespace

void writeRows(PendingFile& file, std::uint64_t offset, const ExportedVolume& volume, const VoxelBox& box,
               std::span<const std::byte> voxels) {
  const Extent3 whole = volume.geometry.dims, extent = box.extent();
  const std::uint64_t voxel_bytes = sizeOf(volume.type);
  const auto placeOfSlice = [&](std::int64_t z) {
    const std::int64_t row = (z - volume.box.lo.z) * whole.y + box.lo.y - volume.box.lo.y;
    return offset + static_cast<std::uint64_t>(row * whole.x) * voxel_bytes;
  };
  if (extent.y == whole.y) return file.writeAt(placeOfSlice(box.lo.z), voxels);
  const std::size_t slice_bytes = static_cast<std::size_t>(extent.x * extent.y) * voxel_bytes;
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z)
    file.writeAt(placeOfSlice(z), voxels.subspan(static_cast<std::size_t>(z - box.lo.z) * slice_bytes, slice_bytes));
}

std::unique_ptr<VolumeWriter> linearWriter(const ExportTarget& target, const ExportedVolume& volume,
                                           LinearLayout layout) {
  requirePlace(target.store, target.out, target.overwrite, target.disk);
  if (!layout.voxels_file.empty()) requirePlace(target.store, layout.voxels_file, target.overwrite, target.disk);
  return std::make_unique<LinearWriter>(target, volume, std::move(layout));
}

}  // namespace kiln
