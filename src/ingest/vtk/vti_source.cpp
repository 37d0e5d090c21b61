// Images of VTK in XML (.vti): one array of one value a point or a cell. Raw arrays without compression are read as raw
// files, numbers as text forwards. Base64 and compressed blocks are read row by row; decoded blocks are cached.
#include <fmt/format.h>

#include <bit>
#include <cassert>

#include "base/error.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/bytes/value_map.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"
#include "ingest/vtk/vti_bytes.h"
#include "ingest/vtk/vti_header.h"
#include "ingest/vtk/vtk_types.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

/// Voxels x fastest in the bytes of an array.
class VtiSource : public VolumeSource {
 public:
  VtiSource(SourceInfo info, std::unique_ptr<VtiArrayBytes> bytes, const ValueMap& map)
      : info_(std::move(info)), bytes_(std::move(bytes)), map_(map) {}

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }
  void read(const VoxelBox& box, std::span<std::byte> out) override;
  std::uint64_t decodeBytes() const override { return bytes_->decodeBytes() + map_.pieceBytes(); }
  std::uint64_t heldBytes() const override { return bytes_->heldBytes(); }
  void keepDecoded(std::uint64_t bytes) override { bytes_->setCache(bytes); }

 private:
  SourceInfo info_;
  std::unique_ptr<VtiArrayBytes> bytes_;
  ValueMap map_;
};

void VtiSource::read(const VoxelBox& box, std::span<std::byte> out) {
  assert(intersection(box, boxOf(info_.geometry.dims)) == box);
  if (box.empty()) return;
  const Extent3 dims = info_.geometry.dims, n = box.extent();
  // Rows that follow each other in the file are one run.
  const std::int64_t rows = n.x == dims.x ? n.y : 1;
  const auto run = static_cast<std::uint64_t>(n.x * rows);
  std::byte* to = out.data();
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; y += rows, to += run * sizeOf(map_.to)) {
      std::uint64_t at = static_cast<std::uint64_t>((z * dims.y + y) * dims.x + box.lo.x) * sizeOf(map_.from);
      readMapped(map_, run, to, info_.files.front(), z, [&](std::span<std::byte> piece) {
        bytes_->read(at, piece);
        at += piece.size();
      });
    }
  }
}

// Returns the place of the first character from `begin` on that is no space or line end. unit: bytes.
std::uint64_t behindSpaces(const File& file, std::uint64_t begin) {
  std::string text(4096, '\0');
  while (const std::size_t got = file.readSomeAt(begin, std::as_writable_bytes(std::span(text)))) {
    const std::size_t first = std::string_view(text).substr(0, got).find_first_not_of(" \t\r\n");
    if (first != std::string_view::npos) return begin + first;
    begin += got;
  }
  return begin;
}

VtiText textOf(const VtiHeader& header, const VtiArray& array, const fs::path& path) {
  File file(path);
  const auto refuse = [&](const std::string& what) { throw Error(ErrorCode::kFormat, path, array.name, what); };
  if (array.format == VtiFormat::kAppended) {
    if (!header.appended) refuse("its data are said to be appended, but the file has no appended data");
    if (array.begin > file.size() || *header.appended > file.size() - array.begin)
      refuse(
          fmt::format("its data should begin at byte {} of the appended data, beyond the end of the file; it is cut "
                      "short",
                      array.begin));
    return {std::move(file), *header.appended + array.begin, header.appended_in_base64};
  }
  const std::uint64_t begin = behindSpaces(file, array.begin);
  return {std::move(file), begin, true};
}

}  // namespace

std::unique_ptr<VolumeSource> openVti(const fs::path& input, const SourceOptions& options) {
  const VtiHeader header = readVtiHeader(input);
  const VtkChoice choice = chosenVtkArray({header.arrays.begin(), header.arrays.end()}, options, input);
  const VtiArray& array = header.arrays[choice.index];
  SourceInfo info;
  info.format = "VTK image" + choice.part;
  info.files = {input};
  info.type = array.type->voxel();
  if (!choice.note.empty()) info.notes.push_back(choice.note);
  info.geometry =
      vtkGeometry(input, header.extent, array.of_cells, header.origin, header.spacing, header.direction, options);
  LinearData data;
  data.file = input;
  data.stored_type = *array.type;
  data.big_endian = header.big_endian;
  data.has_trailer = true;
  if (array.format == VtiFormat::kAscii) {
    data.encoding = DataEncoding::kDecimal;
    data.offset_bytes = array.begin;
    return openDescribed(input, std::move(info), data);
  }
  auto bytes = std::make_unique<VtiArrayBytes>(
      textOf(header, array, input), VtiLengths{header.wide_lengths, header.big_endian}, header.codec,
      checkedBytes(info.geometry.dims, *array.type, input), options.memory_bytes);
  const bool raw = array.format == VtiFormat::kAppended && !header.appended_in_base64;
  if (raw && header.codec == BlockCodec::kNone) {
    data.offset_bytes = bytes->begin();
    return openDescribed(input, std::move(info), data);
  }
  const ValueMap map = {*array.type, info.type, header.big_endian != (std::endian::native == std::endian::big)};
  return std::make_unique<VtiSource>(std::move(info), std::move(bytes), map);
}

}  // namespace kiln
