// Layout: header, first directory, its values, all voxels, all other directories. ImageJ finds the slices by the first
// directory alone; all other programs follow the directories. Lengths are in ImageJ's description.
// Sources: TIFF 6.0; BigTIFF (libtiff.gitlab.io/libtiff/specification/bigtiff.html); ImageJ's TiffEncoder.
#include "export/tiff/tiff_pages.h"

#include <fmt/format.h>
#include <tiff.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "base/byte_record.h"

namespace kiln {
namespace {

// Voxels begin at a multiple of this many bytes.
constexpr std::uint64_t kStripAlignment = 16;

std::uint64_t alignedUp(std::uint64_t bytes, std::uint64_t alignment) {
  return (bytes + alignment - 1) / alignment * alignment;
}

std::uint16_t sampleFormatOf(VoxelType type) {
  if (isFloating(type)) return SAMPLEFORMAT_IEEEFP;
  const bool has_sign = type == VoxelType::i8 || type == VoxelType::i16 || type == VoxelType::i32;
  return has_sign ? SAMPLEFORMAT_INT : SAMPLEFORMAT_UINT;
}

// Pixels per unit as the fraction with the largest terms. The description has the exact length of a pixel.
struct TiffFraction {
  explicit TiffFraction(double spacing) {
    constexpr double kMost = std::numeric_limits<std::uint32_t>::max();
    denominator = whole(spacing < 1 ? std::floor(kMost * spacing) : kMost);
    numerator = whole(denominator / spacing);
  }
  static std::uint32_t whole(double v) {
    return static_cast<std::uint32_t>(std::clamp<double>(std::round(v), 1, std::numeric_limits<std::uint32_t>::max()));
  }
  std::uint32_t numerator, denominator;
};
static_assert(sizeof(TiffFraction) == 8, "two numbers of 32 bits, as the file has them");

// ImageJ's description. The last two lines are Kiln's: ImageJ passes them over and takes the resolution of the tags.
std::string imageJText(const ExportedVolume& volume, std::int64_t pages) {
  const glm::dvec3 spacing = volume.geometry.spacing();
  std::string out = fmt::format("ImageJ=1.11a\nimages={0}\nslices={0}\n", pages);
  if (!volume.geometry.unit.empty() && volume.geometry.unit.find('\n') == std::string::npos)
    out += fmt::format("unit={}\n", volume.geometry.unit);
  return out +
         fmt::format("spacing={}\nloop=false\npixel_width={}\npixel_height={}\n", spacing.z, spacing.x, spacing.y);
}

// Appends the entries of a directory, in either width of counts and offsets.
class EntryList {
 public:
  explicit EntryList(bool big) : big_(big) {}

  void add(std::uint16_t tag, TIFFDataType type, std::uint64_t count, std::uint64_t value) {
    appendValue(bytes_, tag);
    appendValue(bytes_, static_cast<std::uint16_t>(type));
    appendWord(count);
    appendWord(value);  // little-endian: a shorter value fills the first bytes
    ++count_;
  }
  void addShort(std::uint16_t tag, std::uint16_t value) { add(tag, TIFF_SHORT, 1, value); }
  void addLong(std::uint16_t tag, std::int64_t value) { add(tag, TIFF_LONG, 1, static_cast<std::uint64_t>(value)); }
  void addOffset(std::uint16_t tag, std::uint64_t value) { add(tag, big_ ? TIFF_LONG8 : TIFF_LONG, 1, value); }
  // A fraction fits into the entry of a BigTIFF; in a classic file it is at `place`.
  void addFraction(std::uint16_t tag, const TiffFraction& fraction, std::uint64_t place) {
    std::uint64_t value = place;
    if (big_) std::memcpy(&value, &fraction, sizeof value);
    add(tag, TIFF_RATIONAL, 1, value);
  }
  std::vector<std::byte> directory(std::uint64_t next) {
    std::vector<std::byte> entries = std::move(bytes_);
    bytes_.clear();
    if (big_)
      appendValue(bytes_, std::uint64_t{count_});
    else
      appendValue(bytes_, count_);
    bytes_.insert(bytes_.end(), entries.begin(), entries.end());
    appendWord(next);
    return std::move(bytes_);
  }

 private:
  void appendWord(std::uint64_t value) {
    if (big_)
      appendValue(bytes_, value);
    else
      appendValue(bytes_, static_cast<std::uint32_t>(value));
  }

  bool big_;
  std::uint16_t count_ = 0;
  std::vector<std::byte> bytes_;
};

std::vector<std::byte> tiffHeader(bool big) {
  constexpr std::uint16_t kLittleEndian = TIFF_LITTLEENDIAN, kClassic = TIFF_VERSION_CLASSIC, kBig = TIFF_VERSION_BIG,
                          kOffsetBytes = 8;
  std::vector<std::byte> out;
  appendValue(out, kLittleEndian);
  appendValue(out, big ? kBig : kClassic);
  if (!big) {
    appendValue(out, std::uint32_t{8});
    return out;
  }
  appendValue(out, kOffsetBytes);
  appendValue(out, std::uint16_t{0});
  appendValue(out, std::uint64_t{16});
  return out;
}

constexpr std::uint64_t kNotDescribed = 0;

}  // namespace

TiffPages::TiffPages(const ExportedVolume& volume, std::int64_t pages)
    : volume_(volume), pages_(pages), description_(imageJText(volume, pages)) {
  const std::uint64_t voxel_bytes = stripBegin(pages) - stripBegin(0);
  // Directories of a classic file have 14 entries or fewer.
  constexpr std::uint64_t kDirectory = 14 * 12 + 6, kHead = 4096;
  big_ =
      voxel_bytes + static_cast<std::uint64_t>(pages) * kDirectory + kHead > std::numeric_limits<std::uint32_t>::max();
  head_ = tiffHeader(big_);
  // The first directory is built twice: its length gives the places of its values.
  const std::uint64_t values = head_.size() + entries(0, 1).size();
  resolution_begin_ = values;
  const std::uint64_t described_at = values + 2 * sizeof(TiffFraction);
  const std::uint64_t begin = alignedUp(described_at + description_.size() + 1, kStripAlignment);
  const std::size_t header_bytes = head_.size();
  head_.resize(begin);
  const std::vector<std::byte> first = entries(0, described_at);
  std::copy(first.begin(), first.end(), head_.begin() + static_cast<std::ptrdiff_t>(header_bytes));
  const glm::dvec3 spacing = volume.geometry.spacing();
  const TiffFraction resolution[] = {TiffFraction(spacing.x), TiffFraction(spacing.y)};
  std::memcpy(&head_[resolution_begin_], resolution, sizeof resolution);
  std::memcpy(&head_[described_at], description_.c_str(), description_.size());
}

std::uint64_t TiffPages::stripBegin(std::int64_t page) const {
  const Extent3& dims = volume_.geometry.dims;
  return head_.size() + static_cast<std::uint64_t>(dims.x * dims.y * page) * sizeOf(volume_.type);
}

std::uint64_t TiffPages::laterBytes() const {
  constexpr std::uint64_t kEntries = 13;
  return big_ ? 16 + kEntries * 20 : 6 + kEntries * 12;
}

// The first directory follows the header; later ones are behind the last voxel, at an even byte.
std::uint64_t TiffPages::directoryBegin(std::int64_t page) const {
  return alignedUp(stripBegin(pages_), 2) + static_cast<std::uint64_t>(page - 1) * laterBytes();
}

std::vector<std::byte> TiffPages::entries(std::int64_t page, std::uint64_t described_at) const {
  const Extent3& dims = volume_.geometry.dims;
  EntryList list(big_);
  list.addLong(TIFFTAG_IMAGEWIDTH, dims.x);
  list.addLong(TIFFTAG_IMAGELENGTH, dims.y);
  list.addShort(TIFFTAG_BITSPERSAMPLE, static_cast<std::uint16_t>(8 * sizeOf(volume_.type)));
  list.addShort(TIFFTAG_COMPRESSION, COMPRESSION_NONE);
  list.addShort(TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
  if (described_at != kNotDescribed)
    list.add(TIFFTAG_IMAGEDESCRIPTION, TIFF_ASCII, description_.size() + 1, described_at);
  list.addOffset(TIFFTAG_STRIPOFFSETS, stripBegin(page));
  list.addShort(TIFFTAG_SAMPLESPERPIXEL, 1);
  list.addLong(TIFFTAG_ROWSPERSTRIP, dims.y);
  list.addOffset(TIFFTAG_STRIPBYTECOUNTS, stripBegin(1) - stripBegin(0));
  const glm::dvec3 spacing = volume_.geometry.spacing();
  list.addFraction(TIFFTAG_XRESOLUTION, TiffFraction(spacing.x), resolution_begin_);
  list.addFraction(TIFFTAG_YRESOLUTION, TiffFraction(spacing.y), resolution_begin_ + sizeof(TiffFraction));
  list.addShort(TIFFTAG_RESOLUTIONUNIT, RESUNIT_NONE);
  list.addShort(TIFFTAG_SAMPLEFORMAT, sampleFormatOf(volume_.type));
  return list.directory(page + 1 < pages_ ? directoryBegin(page + 1) : 0);
}

std::vector<std::byte> TiffPages::directory(std::int64_t page) const { return entries(page, kNotDescribed); }

}  // namespace kiln
