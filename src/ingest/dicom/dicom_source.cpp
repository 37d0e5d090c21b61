// A DICOM series: slices in files of their own, or frames of one file. Uncompressed rows are read in place, any box
// from any thread. A compressed frame is decoded whole and cached for neighbouring boxes.
// Values are rescaled, in the narrowest type that holds all of them exactly, or mapped by a table. Values of
// MONOCHROME1 images (zero is white) are not inverted; a note reports the fact.
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/error.h"
#include "base/thread/parallel.h"
#include "ingest/bytes/block_cache.h"
#include "ingest/bytes/gather_rows.h"
#include "ingest/bytes/handle_pool.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/bytes/value_map.h"
#include "ingest/dicom/dicom_bytes.h"
#include "ingest/dicom/dicom_decode.h"
#include "ingest/dicom/dicom_segmentation.h"
#include "ingest/dicom/dicom_series.h"
#include "ingest/source/chosen_part.h"
#include "ingest/source/formats.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Keeps the stored bits of each value: the other bits may hold graphics drawn by old scanners (overlays).
template <class T>
void keepStoredBits(std::byte* data, std::size_t count, const DicomPixels& pixels) noexcept {
  using Unsigned = std::make_unsigned_t<T>;
  const int up = pixels.bits_allocated - 1 - pixels.high_bit, down = pixels.bits_allocated - pixels.bits_stored;
  for (std::size_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, data + i * sizeof(T), sizeof(T));
    value = static_cast<T>(static_cast<T>(static_cast<Unsigned>(static_cast<Unsigned>(value) << up)) >> down);
    std::memcpy(data + i * sizeof(T), &value, sizeof(T));
  }
}

// Extends the sign if GDCM's codec did not: such values lie between 0 and a power of two.
template <class T>
void extendSign(std::byte* data, std::size_t count, int bits) noexcept {
  const std::int64_t values = std::int64_t{1} << bits;
  for (std::size_t i = 0; i < count; ++i) {
    T value;
    std::memcpy(&value, data + i * sizeof(T), sizeof(T));
    if (value >= values / 2 && value < values) value = static_cast<T>(value - values);
    std::memcpy(data + i * sizeof(T), &value, sizeof(T));
  }
}

class DicomSource : public VolumeSource {
 public:
  DicomSource(SourceInfo info, std::vector<DicomHeader> files, std::vector<DicomSlice> slices)
      : info_(std::move(info)), files_(std::move(files)), slices_(std::move(slices)) {
    info_.type = type();
  }

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }
  void read(const VoxelBox& box, std::span<std::byte> out) override;
  // Deflated: the pixels and the stream.
  std::uint64_t decodeBytes() const override {
    const auto any = [&](auto test) { return std::any_of(files_.begin(), files_.end(), test); };
    const std::uint64_t frame_bytes = files_.front().pixels.frameBytes();
    if (any([](const DicomHeader& h) { return h.pixels.packed; }))
      return DicomDecoder::decodeBytes(files_.front().pixels);
    const bool deflated = any([](const DicomHeader& h) { return h.pixels.deflated_offset_bytes > 0; });
    if (deflated) return frame_bytes + InflateStream::kHeldBytes;
    return any([](const DicomHeader& h) { return h.pixels.in_words; }) ? 2 * frame_bytes : 0;
  }
  std::uint64_t heldBytes() const override {
    std::uint64_t frames = 0;
    for (const DicomHeader& file : files_) frames += file.frames.size();
    return frames * sizeof(DicomFrame) + slices_.capacity() * sizeof(DicomSlice);
  }
  std::optional<DecodedBlocks> decodedBlocks() const override {
    const DicomPixels& pixels = files_.front().pixels;
    if (decodeBytes() == 0) return std::nullopt;
    return DecodedBlocks{{pixels.columns, pixels.rows, 1}, pixels.frameBytes(), cache_.decodings()};
  }
  void keepDecoded(std::uint64_t bytes) override { cache_.setCapacity(bytes); }

 private:
  VoxelType type();
  bool storedFit(double lo, double hi);
  const DicomFrame& frame(const DicomSlice& s) const {
    return files_[s.file].frames[static_cast<std::size_t>(s.frame)];
  }
  VoxelType stored() const { return files_.front().pixels.storedType(); }
  void readStored(const VoxelBox& in_slice, std::byte* out);

  SourceInfo info_;
  std::vector<DicomHeader> files_;
  std::vector<DicomSlice> slices_;
  std::vector<std::byte> inflatedFrame(const DicomSlice& slice);
  std::vector<std::byte> frameInWords(const DicomSlice& slice) const;
  std::vector<std::byte> wholeFrame(const DicomSlice& slice);

  static constexpr std::size_t kIdleStreams = 16;  // of InflateStream::kHeldBytes each

  HandlePool<File> open_;
  HandlePool<DicomInflated> inflated_{kIdleStreams};
  DicomDecoder decoder_;
  BlockCache cache_;
};

// Frames of a deflated file are read in file order if possible: the stream then continues behind the last frame.
std::vector<std::byte> DicomSource::inflatedFrame(const DicomSlice& slice) {
  const DicomHeader& header = files_[slice.file];
  const DicomPixels& pixels = header.pixels;
  std::vector<std::byte> out(static_cast<std::size_t>(pixels.frameBytes()));
  const auto stream = inflated_.take(
      slice.file, [&] { return std::make_unique<DicomInflated>(header.path, pixels.deflated_offset_bytes); });
  const std::uint64_t at = pixels.offset_bytes + static_cast<std::uint64_t>(slice.frame) * pixels.frameBytes();
  if (stream->readSomeAt(at, out) < out.size())
    throw Error(ErrorCode::kFormat, header.path, fmt::format("frame {}", slice.frame + 1),
                "the deflated elements end before its last pixel; the file is cut short or its header is wrong");
  return out;
}

// A frame may begin and end inside a word.
std::vector<std::byte> DicomSource::frameInWords(const DicomSlice& slice) const {
  const DicomPixels& pixels = files_[slice.file].pixels;
  const std::uint64_t at = static_cast<std::uint64_t>(slice.frame) * pixels.frameBytes(), first = at / 2 * 2;
  std::vector<std::byte> words(static_cast<std::size_t>((at + pixels.frameBytes() + 1) / 2 * 2 - first));
  File(files_[slice.file].path).readAt(pixels.offset_bytes + first, words);
  swapBytes(words.data(), words.size() / 2, 2);
  const auto begin = words.begin() + static_cast<std::ptrdiff_t>(at - first);
  return {begin, begin + static_cast<std::ptrdiff_t>(pixels.frameBytes())};
}

std::vector<std::byte> DicomSource::wholeFrame(const DicomSlice& slice) {
  const DicomHeader& header = files_[slice.file];
  if (header.pixels.packed) return decoder_.frame(header, slice.frame);
  return header.pixels.in_words ? frameInWords(slice) : inflatedFrame(slice);
}

// Reads the stored values of a part of one slice.
void DicomSource::readStored(const VoxelBox& in_slice, std::byte* out) {
  const DicomSlice& slice = slices_[static_cast<std::size_t>(in_slice.lo.z)];
  const DicomHeader& header = files_[slice.file];
  const DicomPixels& pixels = header.pixels;
  const std::uint64_t size = sizeOf(stored()), line = static_cast<std::uint64_t>(pixels.columns) * size;
  const std::uint64_t first =
      static_cast<std::uint64_t>(in_slice.lo.y) * line + static_cast<std::uint64_t>(in_slice.lo.x) * size;
  const auto rows = static_cast<std::uint64_t>(in_slice.extent().y);
  const std::uint64_t row = static_cast<std::uint64_t>(in_slice.extent().x) * size;
  const auto count = static_cast<std::size_t>(in_slice.count());
  if (pixels.packed || pixels.deflated_offset_bytes > 0 || pixels.in_words) {
    const auto frame_values = cache_.get({in_slice.lo.z, 0}, [&](BlockCache::Bytes) { return wholeFrame(slice); });
    for (std::uint64_t y = 0; y < rows; ++y) std::memcpy(out + y * row, frame_values->data() + first + y * line, row);
  } else {
    const auto file = open_.take(slice.file, [&] { return std::make_unique<File>(header.path); });
    const std::uint64_t offset = pixels.offset_bytes + static_cast<std::uint64_t>(slice.frame) * pixels.frameBytes();
    gatherRows(*file, offset + first, rows, row, line, out);
  }
  if (!pixels.packed && size > 1 && pixels.big_endian != (std::endian::native == std::endian::big))
    swapBytes(out, count, size);
  if (pixels.bits_stored == pixels.bits_allocated) return;
  withVoxelType(stored(), [&]<class T>(std::type_identity<T>) {
    if constexpr (std::is_integral_v<T>) {
      if (!pixels.packed)
        keepStoredBits<T>(out, count, pixels);
      else if (pixels.is_signed)
        extendSign<T>(out, count, pixels.bits_stored);
    }
  });
}

void DicomSource::read(const VoxelBox& box, std::span<std::byte> out) {
  assert(intersection(box, boxOf(info_.geometry.dims)) == box);
  assert(out.size() == static_cast<std::size_t>(box.count()) * sizeOf(info_.type));
  if (box.empty()) return;
  const std::size_t count = static_cast<std::size_t>(box.extent().x * box.extent().y);
  std::vector<std::byte> values;
  std::byte* to = out.data();
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z, to += count * sizeOf(info_.type)) {
    const VoxelBox in_slice = {{box.lo.x, box.lo.y, z}, {box.hi.x, box.hi.y, z + 1}};
    const DicomSlice& slice = slices_[static_cast<std::size_t>(z)];
    const ValueMap map = frame(slice).map(stored(), info_.type);
    const DicomLut* const lut = files_[slice.file].lut.get();
    if (map.copies() && lut == nullptr) {
      readStored(in_slice, to);
      continue;
    }
    values.resize(count * sizeOf(map.from));
    readStored(in_slice, values.data());
    if (lut != nullptr)
      lut->apply(map.from.voxel(), values.data(), count, info_.type, to);
    else
      map.apply(values.data(), count, to);
  }
}

// Returns the narrowest type for all possible values, else for all values that occur.
VoxelType DicomSource::type() {
  if (files_.front().lut) {
    const auto is_wide = [](const DicomHeader& file) { return file.lut->type() == VoxelType::u16; };
    return std::any_of(files_.begin(), files_.end(), is_wide) ? VoxelType::u16 : VoxelType::u8;
  }
  double least = std::numeric_limits<double>::infinity(), most = -least;
  bool whole = true, same = true, merges = false;
  for (const DicomSlice& s : slices_) {
    const ValueMap map = frame(s).map(stored(), stored());
    whole = whole && map.slope == 1 && map.intercept == std::floor(map.intercept);
    same = same && map.copies();
    merges = merges || map.mergesInFloat();
    least = std::min(least, map.intercept);
    most = std::max(most, map.intercept);
  }
  if (same) return stored();
  if (sizeOf(stored()) > 2 || merges) return VoxelType::f64;
  if (!whole) return VoxelType::f32;
  // Scanners use few of 16 bits, but declare all of them: the values that occur decide.
  if (storedFit(-32768 - least, 32767 - most)) return VoxelType::i16;
  return storedFit(-least, 65535 - most) ? VoxelType::u16 : VoxelType::f32;
}

// True if every stored value is from `lo` to `hi`. cost: reads the pixels if the number of bits does not decide.
bool DicomSource::storedFit(double lo, double hi) {
  int bits = 0;
  for (const DicomHeader& header : files_) bits = std::max(bits, header.pixels.bits_stored);
  const double values = std::exp2(bits);
  const bool is_signed = files_.front().pixels.is_signed;
  const double can_lo = is_signed ? -values / 2 : 0, can_hi = is_signed ? values / 2 - 1 : values - 1;
  if (can_lo >= lo && can_hi <= hi) return true;
  if (can_lo > hi || can_hi < lo || lo > hi) return false;
  const Extent3& dims = info_.geometry.dims;
  std::atomic<bool> fit = true;
  parallelFor(slices_.size(), [&](std::size_t z) {
    constexpr std::int64_t kChunkPixels = 1 << 18;
    const std::int64_t step = std::max<std::int64_t>(kChunkPixels / dims.x, 1);
    std::vector<std::byte> part;
    for (std::int64_t y = 0; y < dims.y && fit; y += step) {
      const auto at = static_cast<std::int64_t>(z);
      const VoxelBox rows = {{0, y, at}, {dims.x, std::min(y + step, dims.y), at + 1}};
      part.resize(static_cast<std::size_t>(rows.count()) * sizeOf(stored()));
      readStored(rows, part.data());
      withVoxelType(stored(), [&]<class T>(std::type_identity<T>) {
        for (std::size_t i = 0; i < part.size(); i += sizeof(T)) {
          T value;
          std::memcpy(&value, &part[i], sizeof(T));
          if (static_cast<double>(value) < lo || static_cast<double>(value) > hi) fit = false;
        }
      });
    }
  });
  return fit;
}

// Each segmentation object is a volume.
const DicomHeader& onlyOf(const std::vector<DicomHeader>& files, const fs::path& input) {
  if (files.size() == 1) return files.front();
  throw Error(ErrorCode::kUsage, input, "",
              fmt::format("holds {} segmentation objects in one series; name the file of one, as {}", files.size(),
                          files.front().path.string()));
}

}  // namespace

std::unique_ptr<VolumeSource> openDicom(const SliceFiles& input, const SourceOptions& options) {
  SourceInfo info;
  info.notes = input.notes;
  std::vector<DicomHeader> files = readSeries(input, options, info.notes);
  if (input.files.size() != 1 || input.files.front() != input.input) info.files.push_back(input.input);
  for (const DicomHeader& header : files) info.files.push_back(header.path);
  info.format = fmt::format("DICOM, series {}", files.front().series);
  if (!files.front().largest_fraction) chosenChannel(options, std::vector<std::string>(1), input.input);
  if (!files.front().segments.empty()) return openSegmentation(std::move(info), onlyOf(files, input.input), options);
  if (files.front().pixels.smallest_is_white)
    info.notes.push_back(
        "the DICOM files show their smallest values white (MONOCHROME1); the values are taken as stored, and a "
        "transfer function decides what is bright");
  std::vector<DicomSlice> slices;
  info.geometry = arrangeSlices(input.input, files, options, slices, info.notes);
  checkedBytes(info.geometry.dims, files.front().pixels.storedType(), input.input);
  return std::make_unique<DicomSource>(std::move(info), std::move(files), std::move(slices));
}

}  // namespace kiln
