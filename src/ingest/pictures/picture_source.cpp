// A folder of grey PNG or JPEG files as a volume, one file a slice, in natural order of the names. Decoded slices are
// cached for neighbouring boxes.
#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstring>

#include "base/error.h"
#include "ingest/bytes/block_cache.h"
#include "ingest/bytes/linear_source.h"
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
  PictureSource(SourceInfo info, SliceFiles slices, const PictureSlice& header)
      : info_(std::move(info)), slices_(std::move(slices)), header_(header) {}

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }
  void read(const VoxelBox& box, std::span<std::byte> out) override;
  // The file and the decoded slice; files are hardly longer than their slices.
  std::uint64_t decodeBytes() const override { return 2 * header_.bytes(); }
  void keepDecoded(std::uint64_t bytes) override { cache_.setCapacity(bytes); }

 private:
  BlockCache::Bytes decode(std::int64_t z) const {
    const std::filesystem::path& path = slices_.files[static_cast<std::size_t>(z)];
    return slices_.format == SliceFormat::kPng ? decodePng(path, header_) : decodeJpeg(path, header_);
  }

  SourceInfo info_;
  SliceFiles slices_;
  PictureSlice header_;
  BlockCache cache_;
};

void PictureSource::read(const VoxelBox& box, std::span<std::byte> out) {
  assert(intersection(box, boxOf(info_.geometry.dims)) == box);
  if (box.empty()) return;
  const std::size_t size = sizeOf(info_.type), row = static_cast<std::size_t>(box.extent().x) * size;
  const std::size_t line = static_cast<std::size_t>(header_.width) * size;
  std::byte* to = out.data();
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    const auto slice = cache_.get({z, 0}, [&] { return decode(z); });
    const std::byte* from = slice->data() + static_cast<std::size_t>(box.lo.x) * size;
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y, to += row)
      std::memcpy(to, from + static_cast<std::size_t>(y) * line, row);
  }
}

PictureSlice pictureHeaderOf(const SliceFiles& slices, std::size_t i) {
  return slices.format == SliceFormat::kPng ? readPngHeader(slices.files[i]) : readJpegHeader(slices.files[i]);
}

// A picture has one channel and one time.
void requireOneChoice(const SourceOptions& options, const std::filesystem::path& input) {
  chosenChannel(options, std::vector<std::string>(1), input);
  chosenTime(options, 1, input);
}

}  // namespace

std::unique_ptr<VolumeSource> openPictures(const SliceFiles& input, const SourceOptions& options) {
  if (input.part.empty()) requireOneChoice(options, input.input);
  const PictureSlice first = pictureHeaderOf(input, 0);
  for (std::size_t i = 1; i < input.files.size(); ++i) {
    if (const PictureSlice slice = pictureHeaderOf(input, i); !(slice == first))
      throw Error(ErrorCode::kFormat, input.files[i], "",
                  fmt::format("slice {} is {}, but the first, in {}, is {}; slices of one volume are alike", i,
                              describe(slice), input.files[0].filename().string(), describe(first)));
  }
  SourceInfo info;
  info.format = fmt::format("{}, {} {}{}", input.format == SliceFormat::kPng ? "PNG" : "JPEG", input.files.size(),
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
  return std::make_unique<PictureSource>(std::move(info), input, first);
}

}  // namespace kiln
