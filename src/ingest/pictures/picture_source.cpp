// A folder of grey PNG, JPEG or JPEG 2000 files as a volume, one file a slice, in natural order of the names. Decoded
// slices are cached for neighbouring boxes.
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>

#include "base/error.h"
#include "ingest/bytes/block_cache.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/pictures/jpeg2000_slice.h"
#include "ingest/pictures/picture_slice.h"
#include "ingest/source/chosen_part.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

std::string describe(const PictureSlice& slice) {
  return fmt::format("{} x {} of {}", slice.width, slice.height, nameOf(slice.type));
}

class PictureSource : public VolumeSource {
 public:
  /// `slice` is alike in all files, and `file_bytes` the size of the largest one.
  PictureSource(SourceInfo info, SliceFiles slices, const PictureSlice& slice, std::uint64_t file_bytes)
      : info_(std::move(info)), slices_(std::move(slices)), slice_(slice), file_bytes_(file_bytes) {}

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }
  void read(const VoxelBox& box, std::span<std::byte> out) override;
  std::uint64_t decodeBytes() const override;
  std::optional<DecodedBlocks> decodedBlocks() const override {
    return DecodedBlocks{{slice_.width, slice_.height, 1}, slice_.bytes(), cache_.decodings()};
  }
  void keepDecoded(std::uint64_t bytes) override { cache_.setCapacity(bytes); }

 private:
  BlockCache::Bytes decode(std::int64_t z) {
    const std::filesystem::path& path = slices_.files[static_cast<std::size_t>(z)];
    if (slices_.format == SliceFormat::kPng) return decodePng(path, slice_, file_bytes_);
    if (slices_.format == SliceFormat::kJpeg) return decodeJpeg(path, slice_, file_bytes_);
    return jpeg2000_.decode(path, slice_, file_bytes_);
  }

  SourceInfo info_;
  SliceFiles slices_;
  PictureSlice slice_;
  std::uint64_t file_bytes_;
  Jpeg2000Decoder jpeg2000_;
  BlockCache cache_;
};

std::uint64_t PictureSource::decodeBytes() const {
  const std::uint64_t both = file_bytes_ + slice_.bytes();
  if (slices_.format == SliceFormat::kJpeg2000) return both + Jpeg2000Decoder::decodeBytes(slice_, file_bytes_);
  if (slices_.format == SliceFormat::kPng) return both;
  return both + kJpegPixelBytes * static_cast<std::uint64_t>(slice_.width * slice_.height);
}

void PictureSource::read(const VoxelBox& box, std::span<std::byte> out) {
  assert(intersection(box, boxOf(info_.geometry.dims)) == box);
  if (box.empty()) return;
  const std::size_t size = sizeOf(info_.type), row = static_cast<std::size_t>(box.extent().x) * size;
  const std::size_t line = static_cast<std::size_t>(slice_.width) * size;
  std::byte* to = out.data();
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    const auto slice = cache_.get({z, 0}, [&](BlockCache::Bytes) { return decode(z); });
    const std::byte* from = slice->data() + static_cast<std::size_t>(box.lo.x) * size;
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y, to += row)
      std::memcpy(to, from + static_cast<std::size_t>(y) * line, row);
  }
}

PictureHeader pictureHeaderOf(SliceFormat format, const std::filesystem::path& path) {
  if (format == SliceFormat::kPng) return readPngHeader(path);
  return format == SliceFormat::kJpeg ? readJpegHeader(path) : readJpeg2000Header(path);
}

// A picture has one channel and one time.
void requireOneChoice(const SourceOptions& options, const std::filesystem::path& input) {
  chosenChannel(options, std::vector<std::string>(1), input);
  chosenTime(options, 1, input);
}

}  // namespace

std::unique_ptr<VolumeSource> openPictures(const SliceFiles& input, const SourceOptions& options) {
  if (input.part.empty()) requireOneChoice(options, input.input);
  auto [first, file_bytes] = pictureHeaderOf(input.format, input.files[0]);
  for (std::size_t i = 1; i < input.files.size(); ++i) {
    const PictureHeader header = pictureHeaderOf(input.format, input.files[i]);
    file_bytes = std::max(file_bytes, header.file_bytes);
    if (!(header.slice == first))
      throw Error(ErrorCode::kFormat, input.files[i], "",
                  fmt::format("slice {} is {}, but the first, in {}, is {}; slices of one volume are alike", i,
                              describe(header.slice), input.files[0].filename().string(), describe(first)));
  }
  SourceInfo info;
  info.format = fmt::format("{}, {} {}{}", nameOf(input.format), input.files.size(),
                            input.files.size() == 1 ? "slice" : "slices", input.part);
  info.files = {input.input};
  info.files.insert(info.files.end(), input.files.begin(), input.files.end());
  info.notes = input.notes;
  info.type = first.type;
  info.geometry.dims = {first.width, first.height, static_cast<std::int64_t>(input.files.size())};
  info.geometry.world_from_index = axesAffine(options.spacing.value_or(glm::dvec3(1)), glm::dvec3(0));
  requireInvertible(info.geometry.world_from_index, input.input.string());
  checkedBytes(info.geometry.dims, info.type, input.input);
  if (!options.spacing)
    info.notes.push_back("pictures have no size of a voxel, which is taken to be 1 x 1 x 1; --spacing sets another");
  return std::make_unique<PictureSource>(std::move(info), input, first, file_bytes);
}

ListedVolume listPictures(SliceFormat format, const std::vector<std::filesystem::path>& stack) {
  ListedVolume out;
  out.name = nameOfStack(stack);
  out.kind = nameOf(format);
  try {
    const PictureSlice first = pictureHeaderOf(format, stack.front()).slice;
    out.dims = Extent3{first.width, first.height, static_cast<std::int64_t>(stack.size())};
    out.type = first.type;
  } catch (const Error& error) {
    out.refusal = error.what();
  }
  return out;
}

}  // namespace kiln
