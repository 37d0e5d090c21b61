// Voxels in linear order, by two sources. `RawSource` gathers any box by pread, from any thread. `StreamSource` reads a
// compressed stream or a text forward and holds one chunk beside the caller's buffer.
// Invariant: all sizes are checked against 63 bits and the file before the first voxel is read, so no later offset
// overflows.
#include "ingest/bytes/linear_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cassert>
#include <limits>

#include "base/error.h"
#include "base/file/file.h"
#include "ingest/bytes/bzip2_stream.h"
#include "ingest/bytes/gather_rows.h"
#include "ingest/bytes/inflate_stream.h"
#include "ingest/bytes/text_stream.h"
#include "ingest/bytes/value_map.h"

namespace kiln {
namespace {

// Upper bound for the bytes of voxels that one byte of the file can hold.
std::uint64_t mostExpansion(DataEncoding encoding) {
  switch (encoding) {
    case DataEncoding::kGzip:
    case DataEncoding::kZlib:
      return 1032;  // zlib's technical notes, "Maximum Compression Factor"
    case DataEncoding::kBzip2:
      return 1 << 22;  // measured on zeros: 1.4 million
    case DataEncoding::kDecimal:
      return 8;  // a digit of an f64, and no blank behind the last one
    case DataEncoding::kRaw:
    case DataEncoding::kShare:
    case DataEncoding::kHex:
      break;
  }
  return 1;
}

ValueMap mapOf(const SourceInfo& info, const LinearData& data) {
  const bool machine_big_endian = std::endian::native == std::endian::big;
  // Numbers as text are parsed to voxels.
  if (data.encoding == DataEncoding::kDecimal)
    return {data.stored_type.voxel(), info.type, false, data.slope, data.intercept};
  return {data.stored_type, info.type, data.big_endian != machine_big_endian, data.slope, data.intercept};
}

// requires: openLinear has checked the product.
std::uint64_t volumeBytes(const SourceInfo& info, const ValueMap& map) {
  return static_cast<std::uint64_t>(info.geometry.dims.count()) * sizeOf(map.from);
}

class RawSource : public VolumeSource {
 public:
  RawSource(SourceInfo info, const LinearData& data, File file)
      : info_(std::move(info)),
        map_(mapOf(info_, data)),
        file_(std::move(file)),
        first_byte_(data.offset_bytes + data.skip_decompressed_bytes +
                    static_cast<std::uint64_t>(data.part) * volumeBytes(info_, map_)) {}

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }
  void read(const VoxelBox& box, std::span<std::byte> out) override;

 private:
  void gather(const VoxelBox& box, std::byte* out) const;

  SourceInfo info_;
  ValueMap map_;
  File file_;
  std::uint64_t first_byte_;
};

void RawSource::read(const VoxelBox& box, std::span<std::byte> out) {
  assert(intersection(box, boxOf(info_.geometry.dims)) == box);
  assert(out.size() == static_cast<std::size_t>(box.count()) * sizeOf(info_.type));
  if (box.empty()) return;
  if (map_.copies()) {
    gather(box, out.data());
    map_.order(out.data(), static_cast<std::size_t>(box.count()));
    return;
  }
  const Extent3 n = box.extent();
  const std::int64_t row_bytes = n.x * static_cast<std::int64_t>(sizeOf(map_.from));
  const std::int64_t step =
      std::clamp<std::int64_t>(static_cast<std::int64_t>(ValueMap::kPieceBytes) / row_bytes, 1, n.y);
  std::vector<std::byte> stored(static_cast<std::size_t>(step * row_bytes));
  std::byte* to = out.data();
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; y += step) {
      const VoxelBox rows = {{box.lo.x, y, z}, {box.hi.x, std::min(y + step, box.hi.y), z + 1}};
      const std::size_t count = static_cast<std::size_t>(rows.count());
      gather(rows, stored.data());
      map_.order(stored.data(), count);
      requireFits(map_, stored.data(), count, file_.path(), z);
      map_.apply(stored.data(), count, to);
      to += count * sizeOf(map_.to);
    }
  }
}

// Reads the stored bytes of a box as the fewest sequences of equal rows at equal distances.
void RawSource::gather(const VoxelBox& box, std::byte* out) const {
  const Extent3 dims = info_.geometry.dims, n = box.extent();
  const std::uint64_t size = sizeOf(map_.from);
  const std::uint64_t line = dims.x * size, slice = dims.y * line, row = n.x * size;
  const std::uint64_t first = first_byte_ + box.lo.z * slice + box.lo.y * line + box.lo.x * size;
  const bool whole_x = n.x == dims.x, whole_y = n.y == dims.y;
  if (whole_x && whole_y) return gatherRows(file_, first, 1, n.z * slice, n.z * slice, out);
  if (whole_x) return gatherRows(file_, first, n.z, n.y * row, slice, out);
  if (whole_y) return gatherRows(file_, first, n.y * n.z, row, line, out);
  for (std::int64_t z = 0; z < n.z; ++z) gatherRows(file_, first + z * slice, n.y, row, line, out + z * n.y * row);
}

std::unique_ptr<ByteStream> openStream(const LinearData& data, File file) {
  switch (data.encoding) {
    case DataEncoding::kBzip2:
      return std::make_unique<Bzip2Stream>(std::move(file), data.offset_bytes);
    case DataEncoding::kDecimal:
      return std::make_unique<DecimalStream>(std::move(file), data.offset_bytes, data.stored_type.voxel());
    case DataEncoding::kShare:
      return std::make_unique<ShareStream>(std::move(file), data.offset_bytes);
    case DataEncoding::kHex:
      return std::make_unique<HexStream>(std::move(file), data.offset_bytes);
    default:
      break;
  }
  const bool gzip = data.encoding == DataEncoding::kGzip;
  return std::make_unique<InflateStream>(std::move(file), data.offset_bytes,
                                         gzip ? StreamWrapper::kGzip : StreamWrapper::kZlib);
}

class StreamSource : public VolumeSource {
 public:
  StreamSource(SourceInfo info, const LinearData& data, File file)
      : info_(std::move(info)),
        map_(mapOf(info_, data)),
        stream_(openStream(data, std::move(file))),
        skip_bytes_(data.skip_decompressed_bytes + static_cast<std::uint64_t>(data.part) * volumeBytes(info_, map_)),
        rest_bytes_(static_cast<std::uint64_t>(data.parts - data.part - 1) * volumeBytes(info_, map_)),
        has_trailer_(data.has_trailer) {}

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kForward; }
  void read(const VoxelBox& box, std::span<std::byte> out) override;
  void finish() override;
  std::uint64_t decodeBytes() const override { return stream_->heldBytes() + map_.pieceBytes(); }

 private:
  std::uint64_t sliceVoxels() const { return info_.geometry.dims.x * info_.geometry.dims.y; }
  std::uint64_t leftInSlice() const { return sliceVoxels() - next_voxel_ % sliceVoxels(); }
  std::string place() const { return "slice " + std::to_string(next_voxel_ / sliceVoxels()); }
  void readRun(std::uint64_t voxels, std::byte* out);
  void skipPrefix() { stream_->skip(std::exchange(skip_bytes_, 0), "before slice 0"); }

  SourceInfo info_;
  ValueMap map_;
  std::unique_ptr<ByteStream> stream_;
  std::uint64_t skip_bytes_;
  std::uint64_t rest_bytes_;  // of further volumes behind this one
  bool has_trailer_;
  std::uint64_t next_voxel_ = 0;  // in the order of the file
};

void StreamSource::read(const VoxelBox& box, std::span<std::byte> out) {
  [[maybe_unused]] const Extent3 dims = info_.geometry.dims, n = box.extent();
  assert(intersection(box, boxOf(dims)) == box && n.x == dims.x && (n.y == dims.y || n.z == 1));
  assert(static_cast<std::uint64_t>((box.lo.z * dims.y + box.lo.y) * dims.x) == next_voxel_);
  assert(out.size() == static_cast<std::size_t>(box.count()) * sizeOf(info_.type));
  skipPrefix();
  std::byte* to = out.data();
  // Reads slice by slice, because an error names the slice.
  for (std::uint64_t left = static_cast<std::uint64_t>(box.count()); left > 0;) {
    const std::uint64_t now = std::min(left, leftInSlice());
    readRun(now, to);
    to += now * sizeOf(map_.to);
    left -= now;
  }
}

void StreamSource::readRun(std::uint64_t voxels, std::byte* out) {
  const std::string where = place();
  const auto slice = static_cast<std::int64_t>(next_voxel_ / sliceVoxels());
  const std::filesystem::path file = info_.files.empty() ? std::filesystem::path() : info_.files.back();
  next_voxel_ += voxels;
  readMapped(map_, voxels, out, file, slice, [&](std::span<std::byte> piece) { stream_->read(piece, where); });
}

void StreamSource::finish() {
  skipPrefix();
  for (const std::uint64_t end = sliceVoxels() * info_.geometry.dims.z; next_voxel_ < end;) {
    const std::uint64_t now = leftInSlice();
    stream_->skip(now * sizeOf(map_.from), place());
    next_voxel_ += now;
  }
  stream_->skip(rest_bytes_, "after the last slice");
  std::vector<std::string> notes = stream_->finish();
  if (has_trailer_) return;
  for (std::string& note : notes) info_.notes.push_back(std::move(note));
}

// Returns the size of all volumes in the data.
std::uint64_t allBytes(const Extent3& dims, const LinearData& data) {
  const std::uint64_t one = checkedBytes(dims, data.stored_type, data.file);
  const auto parts = static_cast<std::uint64_t>(data.parts);
  if (parts > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max()) / one)
    throw Error(ErrorCode::kFormat, data.file, "dimensions", "the volumes would have more than 2^63 bytes");
  return parts * one;
}

}  // namespace

std::uint64_t checkedBytes(const Extent3& dims, StoredType type, const std::filesystem::path& path) {
  constexpr std::int64_t kMaxDim = std::numeric_limits<std::int32_t>::max();
  std::int64_t bytes = static_cast<std::int64_t>(sizeOf(type));
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t n = dims[axis];
    if (n < 1 || n > kMaxDim) {
      throw Error(ErrorCode::kFormat, path, "dimensions",
                  std::to_string(n) + " voxels along an axis; 1 to 2147483647 are legal");
    }
    if (bytes > std::numeric_limits<std::int64_t>::max() / n) {
      throw Error(ErrorCode::kFormat, path, "dimensions", "the volume would have more than 2^63 bytes");
    }
    bytes *= n;
  }
  return static_cast<std::uint64_t>(bytes);
}

void LinearData::beginAt(std::uint64_t offset, bool in_gzip) {
  encoding = in_gzip ? DataEncoding::kGzip : DataEncoding::kRaw;
  (in_gzip ? skip_decompressed_bytes : offset_bytes) = offset;
}

std::unique_ptr<VolumeSource> openLinear(SourceInfo info, const LinearData& data) {
  const std::uint64_t bytes = allBytes(info.geometry.dims, data);
  checkedBytes(info.geometry.dims, info.type, data.file);
  File file(data.file);
  const auto fail = [&](const std::string& what) { throw Error(ErrorCode::kFormat, data.file, "", what); };
  const std::string has = "the file has " + std::to_string(file.size()) + " bytes";
  if (data.offset_bytes > file.size()) {
    fail("the data should begin at byte " + std::to_string(data.offset_bytes) + ", but " + has);
  }
  const std::uint64_t available = file.size() - data.offset_bytes;
  if (data.encoding != DataEncoding::kRaw) {
    const std::uint64_t most = mostExpansion(data.encoding);
    if (bytes / most > available || data.skip_decompressed_bytes / most > available) {
      fail("the header's dimensions and skips need " + std::to_string(bytes) + " bytes, more than " +
           std::to_string(available) + " bytes of compressed data or text can hold");
    }
    return std::make_unique<StreamSource>(std::move(info), data, std::move(file));
  }
  const std::uint64_t skip = data.skip_decompressed_bytes;
  if (skip > available || bytes > available - skip) {
    fail(has + ", but the header's dimensions need " + std::to_string(bytes) + " from byte " +
         std::to_string(data.offset_bytes) + (skip ? " + " + std::to_string(skip) : "") +
         "; the file is cut short or the header is wrong");
  }
  if (const std::uint64_t rest = available - skip - bytes; rest > 0 && !data.has_trailer)
    info.notes.push_back(fmt::format("{}: {} byte{} behind the header's dimensions not read",
                                     data.file.filename().string(), rest, rest == 1 ? "" : "s"));
  return std::make_unique<RawSource>(std::move(info), data, std::move(file));
}

std::unique_ptr<VolumeSource> openDescribed(const std::filesystem::path& header, SourceInfo info,
                                            const LinearData& data) {
  info.files = {header};
  if (data.file != header) info.files.push_back(data.file);
  return openLinear(std::move(info), data);
}

}  // namespace kiln
