// Each file is a source of its own. Raw files are opened by the threads that read them; compressed files and text are
// read one after the other, each to its end.
#include "ingest/bytes/stacked_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "base/error.h"
#include "ingest/bytes/handle_pool.h"

namespace kiln {
namespace {

class StackedSource : public VolumeSource {
 public:
  /// requires: each file was opened once without an error.
  StackedSource(SourceInfo info, SourceInfo part, std::vector<LinearData> files, std::uint64_t decode_bytes)
      : info_(std::move(info)), part_(std::move(part)), files_(std::move(files)), decode_bytes_(decode_bytes) {}

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override {
    return files_[0].encoding == DataEncoding::kRaw ? ReadOrder::kAnyBox : ReadOrder::kForward;
  }
  void read(const VoxelBox& box, std::span<std::byte> out) override;
  void finish() override;
  std::uint64_t decodeBytes() const override { return decode_bytes_; }

 private:
  std::unique_ptr<VolumeSource> open(std::size_t file) const { return openLinear(part_, files_[file]); }
  VolumeSource& reach(std::size_t file);

  SourceInfo info_, part_;
  std::vector<LinearData> files_;
  std::uint64_t decode_bytes_;
  HandlePool<VolumeSource> pool_;          // of raw files
  std::unique_ptr<VolumeSource> current_;  // of files that are read forwards
  std::size_t current_file_ = 0;
};

void StackedSource::read(const VoxelBox& box, std::span<std::byte> out) {
  assert(intersection(box, boxOf(info_.geometry.dims)) == box);
  if (box.empty()) return;
  const std::int64_t slices = part_.geometry.dims.z;
  const std::size_t slice_bytes = out.size() / static_cast<std::size_t>(box.extent().z);
  for (std::int64_t z = box.lo.z; z < box.hi.z;) {
    const std::int64_t file = z / slices, first = file * slices, end = std::min(first + slices, box.hi.z);
    const VoxelBox part = {{box.lo.x, box.lo.y, z - first}, {box.hi.x, box.hi.y, end - first}};
    const auto to = out.subspan(static_cast<std::size_t>(z - box.lo.z) * slice_bytes,
                                static_cast<std::size_t>(end - z) * slice_bytes);
    const auto index = static_cast<std::size_t>(file);
    if (order() == ReadOrder::kAnyBox)
      pool_.take(index, [&] { return open(index); })->read(part, to);
    else
      reach(index).read(part, to);
    z = end;
  }
}

// Ends the files before `file` and returns the source of `file`.
VolumeSource& StackedSource::reach(std::size_t file) {
  while (!current_ || current_file_ < file) {
    if (current_) {
      current_->finish();
      const std::vector<std::string>& notes = current_->info().notes;
      info_.notes.insert(info_.notes.end(), notes.begin(), notes.end());
      ++current_file_;
    }
    current_ = open(current_file_);
  }
  return *current_;
}

void StackedSource::finish() {
  if (order() == ReadOrder::kAnyBox) return;
  reach(files_.size() - 1).finish();
  const std::vector<std::string>& notes = current_->info().notes;
  info_.notes.insert(info_.notes.end(), notes.begin(), notes.end());
}

}  // namespace

Extent3 partOfFile(const Extent3& dims, std::size_t count, const std::filesystem::path& header) {
  if (count == 1) return dims;
  const auto files = static_cast<std::int64_t>(count);
  if (dims.z < 1 || dims.z % files != 0)
    throw Error(ErrorCode::kFormat, header, "",
                fmt::format("names {} data files for {} slices; each file has equally many slices", count, dims.z));
  return {dims.x, dims.y, dims.z / files};
}

std::unique_ptr<VolumeSource> openStacked(const std::filesystem::path& header, SourceInfo info,
                                          std::vector<LinearData> files) {
  if (files.size() == 1) return openDescribed(header, std::move(info), files[0]);
  checkedBytes(info.geometry.dims, info.type, header);
  SourceInfo part = info;
  part.notes.clear();
  part.geometry.dims = partOfFile(info.geometry.dims, files.size(), header);
  std::uint64_t decode_bytes = 0;
  info.files = {header};
  for (const LinearData& data : files) {
    const std::unique_ptr<VolumeSource> source = openLinear(part, data);
    decode_bytes = std::max(decode_bytes, source->decodeBytes());
    const std::vector<std::string>& notes = source->info().notes;
    info.notes.insert(info.notes.end(), notes.begin(), notes.end());
    info.files.push_back(data.file);
  }
  return std::make_unique<StackedSource>(std::move(info), std::move(part), std::move(files), decode_bytes);
}

}  // namespace kiln
