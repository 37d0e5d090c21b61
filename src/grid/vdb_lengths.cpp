#include "grid/vdb_lengths.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <iterator>
#include <map>
#include <set>
#include <string_view>
#include <vector>

namespace kiln {
namespace {

// OpenVDB 1.0 writes version 218. Compression flags belong to the file from 220 on, and to each grid from 222 on.
constexpr std::uint32_t kOldest = 218, kCompressedFiles = 220, kCompressedGrids = 222;
constexpr std::int64_t kVdbMagic = 0x56444220;
// Metadata of a grid by which OpenVDB reads its values.
constexpr std::string_view kHalvesName = "is_saved_as_half_float";
constexpr std::uint64_t kVersionAt = 8, kPlacesFlagAt = 20, kUuidBytes = 36;

// Length of a value of a fixed-length type. OpenVDB reads this many bytes, whatever length the file claims.
std::uint32_t bytesOfType(const std::string& type) {
  static const std::map<std::string, std::uint32_t, std::less<>> kBytes = {
      {"bool", 1},    {"mask", 1},   {"float", 4},  {"double", 8}, {"int32", 4}, {"int64", 8},  {"mat4s", 64},
      {"mat4d", 128}, {"quats", 16}, {"quatd", 32}, {"vec2i", 8},  {"vec2s", 8}, {"vec2d", 16}, {"vec3i", 12},
      {"vec3s", 12},  {"vec3d", 24}, {"vec4i", 16}, {"vec4s", 16}, {"vec4d", 32}};
  const auto found = kBytes.find(type);
  return found == kBytes.end() ? 0 : found->second;
}

// Factor by which half precision shortens a value. Integers keep their length.
std::uint64_t halfShortens(const std::string& type) {
  if (type == "float" || type == "vec2s" || type == "vec3s") return 2;
  return type == "double" || type == "vec2d" || type == "vec3d" ? 4 : 1;
}

// Length of the numbers behind the name of a transform's map; 0 for maps that OpenVDB rejects.
std::uint64_t bytesOfMap(const std::string& map) {
  constexpr std::uint64_t kVector = 3 * sizeof(double), kMatrix = 16 * sizeof(double), kScale = 5 * kVector;
  if (map == "AffineMap" || map == "UnitaryMap") return kMatrix;
  if (map == "TranslationMap") return kVector;
  if (map == "ScaleMap" || map == "UniformScaleMap") return kScale;
  return map == "ScaleTranslateMap" || map == "UniformScaleTranslateMap" ? kVector + kScale : 0;
}

// Slots of inner nodes below the root and above the leaves; voxels of a leaf.
constexpr std::uint64_t kUpperSlots = 1 << 15, kLowerSlots = 1 << 12, kLeafVoxels = 512;
constexpr std::uint64_t kLeafMaskBytes = kLeafVoxels / 8, kOriginBytes = 3 * sizeof(std::int32_t);
// A writer keeps values that compression makes longer. More than this factor, and these bytes, is a false length.
constexpr std::uint64_t kMostPacking = 2, kPackingHead = 256;
// Flags of compression.
constexpr std::uint32_t kZip = 1, kActiveOnly = 2, kBlosc = 4;
// Memory of a node without values and masks (allocator, origin, buffer), and of an entry in the root's table. Measured
// with OpenVDB 10 and glibc, rounded up. unit: bytes.
constexpr std::uint64_t kNodeExtra = 96, kRootEntry = 96;

}  // namespace

void VdbLengths::fail(std::uint64_t at, const std::string& what) const {
  throw Error(file_.code, file_.path, fmt::format("byte {}", at), what);
}

template <class T>
T VdbLengths::number(std::uint64_t at) const {
  std::array<std::byte, sizeof(T)> raw;
  if (at > file_.size || sizeof(T) > file_.size - at)
    fail(at, fmt::format("the file ends here, but {} more bytes are expected", sizeof(T)));
  file_.copy(at, raw);
  return std::bit_cast<T>(raw);
}

template <class T>
T VdbLengths::take() {
  const T value = number<T>(at_);
  at_ += sizeof(T);
  return value;
}

void VdbLengths::skip(std::uint64_t bytes) {
  if (bytes > file_.size - at_) fail(at_, fmt::format("the file ends within the {} bytes that should follow", bytes));
  at_ += bytes;
}

std::string VdbLengths::text() {
  const auto length = take<std::uint32_t>();
  if (length > file_.size - at_) fail(at_ - 4, fmt::format("a length of {} is more than the file holds", length));
  std::string out(length, '\0');
  file_.copy(at_, std::as_writable_bytes(std::span(out)));
  at_ += length;
  return out;
}

std::uint64_t VdbLengths::fileHead(std::uint32_t newest) {
  if (number<std::int64_t>(0) != kVdbMagic) fail(0, "the file does not begin as an OpenVDB file does");
  version_ = number<std::uint32_t>(kVersionAt);
  if (version_ < kOldest || version_ > newest)
    throw Error(ErrorCode::kUnsupported, file_.path, "",
                fmt::format("has version {} of OpenVDB's format; {} to {} are read", version_, kOldest, newest));
  has_places_ = number<std::uint8_t>(kPlacesFlagAt) != 0;
  at_ = kPlacesFlagAt + 1;
  if (version_ >= kCompressedFiles && version_ < kCompressedGrids) skip(1);
  skip(kUuidBytes);
  metadata();
  if (!packed_.empty()) fail(packed_.front().at, "a hint for delayed loading belongs to no grid");
  return at_;
}

// Walks entries of name, type and value, each preceded by its length.
void VdbLengths::metadata() {
  const auto count = take<std::uint32_t>();
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string name = text(), type = text();
    const std::uint64_t length_at = at_;
    const auto length = take<std::uint32_t>();
    if (length > file_.size - at_) fail(length_at, fmt::format("a length of {} is more than the file holds", length));
    if (const std::uint32_t bytes = bytesOfType(type); bytes != 0 && bytes != length)
      fail(length_at, fmt::format("a value of type {} has a length of {}; {} is legal", type, length, bytes));
    if (name == kHalvesName) {
      if (type != "bool") fail(length_at, fmt::format("{} has type {}; bool is legal", name, type));
      halves_ = number<std::uint8_t>(at_) != 0;
    }
    if (type == kDelayedLoadType) packed_.push_back({length_at, 0, VdbPacked::Kind::kHint});
    at_ += length;
  }
}

std::uint64_t VdbLengths::descriptor(std::uint64_t at) {
  at_ = at;
  for (int i = 0; i < 3; ++i) text();  // name, type, and the grid whose tree an instance shares
  const std::uint64_t places_at = at_;
  const auto data = take<std::int64_t>(), blocks = take<std::int64_t>(), end = take<std::int64_t>();
  const bool instance = blocks == 0;
  if (has_places_ && (data < static_cast<std::int64_t>(at_) || end < data ||
                      (!instance && (blocks < data || blocks > end)) || static_cast<std::uint64_t>(end) > file_.size))
    fail(places_at, "a grid's place is not in the file; it is cut short or damaged");
  return at_;
}

std::uint64_t VdbLengths::gridHead(std::uint64_t at) {
  at_ = at;
  packed_.clear();
  halves_ = false;
  if (version_ >= kCompressedGrids) grid_compression_ = take<std::uint32_t>();
  metadata();
  transform();
  return at_;
}

// A frustum holds a second map behind its own numbers.
void VdbLengths::transform() {
  constexpr std::uint64_t kFrustumBytes = 8 * sizeof(double);  // a box, the taper and the depth
  std::string map = text();
  if (map == "NonlinearFrustumMap") {
    skip(kFrustumBytes);
    map = text();
  }
  skip(bytesOfMap(map));
}

bool VdbLengths::knowsMemoryOf(const std::string& type) { return bytesOfType(type) != 0; }

std::uint64_t VdbLengths::treeMemory(std::uint64_t at, const Values& values) {
  at_ = at;
  // OpenVDB would only print a warning and read the first buffer.
  if (const auto buffers = take<std::int32_t>(); buffers != 1)
    throw Error(ErrorCode::kUnsupported, file_.path, fmt::format("byte {}", at),
                fmt::format("the tree has {} buffers, of which one is read; save the grid anew with one", buffers));
  if (values.half != halves_)
    throw Error(ErrorCode::kUnsupported, file_.path, fmt::format("byte {}", at),
                "the grid's name and its metadata differ about half precision; save the grid anew");
  const std::uint64_t value_bytes = bytesOfType(values.type);
  skip(value_bytes);  // the background
  const auto tiles = take<std::uint32_t>(), children = take<std::uint32_t>();
  skip(tiles * (kOriginBytes + value_bytes + 1));
  std::uint64_t out = tiles * kRootEntry;
  leaves_ = 0;
  const auto hints = std::ssize(packed_);
  std::set<std::array<std::int32_t, 3>> origins;
  for (std::uint32_t i = 0; i < children; ++i) {
    // A node in the place of another would take leaves away from OpenVDB's tree.
    if (!origins.insert(take<std::array<std::int32_t, 3>>()).second)
      fail(at_ - kOriginBytes, "two nodes of the tree have one place");
    out += kRootEntry + innerNode(kUpperSlots, values);
  }
  has_packed_nodes_ =
      std::any_of(packed_.begin() + hints, packed_.end(), [](const VdbPacked& p) { return p.bytes > 0; });
  const bool packs = (version_ >= kCompressedGrids ? grid_compression_ : values.compression) & (kZip | kBlosc);
  if (packs) packed_.reserve(packed_.size() + leaves_);
  for (std::uint64_t i = 0; i < leaves_; ++i) leaf(values);
  return out + packed_.capacity() * sizeof(VdbPacked);
}

// Returns the memory of a node and all nodes below.
std::uint64_t VdbLengths::innerNode(std::uint64_t slots, const Values& values) {
  const std::uint64_t value_bytes = bytesOfType(values.type);
  // A slot is a union of a child pointer and a small value; a large value lies beside the pointer.
  const std::uint64_t slot_bytes = sizeof(void*) + (value_bytes > sizeof(void*) ? value_bytes : 0);
  const std::uint64_t children = bitsOf(slots), active = bitsOf(slots);
  valuesOfNode(slots, children, active, values);
  std::uint64_t out = slots * slot_bytes + 2 * slots / 8 + kNodeExtra;
  if (slots == kLowerSlots) {
    skip(children * kLeafMaskBytes);
    leaves_ += children;
    return out + children * (kLeafVoxels * value_bytes + kLeafMaskBytes + kNodeExtra);
  }
  for (std::uint64_t i = 0; i < children; ++i) out += innerNode(kLowerSlots, values);
  return out;
}

// Walks the values of a leaf, which follow all nodes. A leaf of masks has one or two masks and no values.
void VdbLengths::leaf(const Values& values) {
  if (values.type == "mask") return skip(kLeafMaskBytes + kOriginBytes);
  if (values.type == "bool") return skip(kLeafMaskBytes + kOriginBytes + kLeafMaskBytes);
  const std::uint64_t active = bitsOf(kLeafVoxels);
  if (version_ < kCompressedGrids) {
    skip(kOriginBytes);
    if (const auto buffers = take<std::int8_t>(); buffers > 1)
      fail(at_ - 1, fmt::format("a leaf has {} buffers; 1 is legal", buffers));
  }
  valuesOfNode(kLeafVoxels, 0, active, values);
}

// Returns the number of set bits in a mask.
std::uint64_t VdbLengths::bitsOf(std::uint64_t slots) {
  std::vector<std::byte> mask(slots / 8);
  const std::uint64_t at = at_;
  skip(mask.size());
  file_.copy(at, mask);
  std::uint64_t out = 0;
  for (const std::byte byte : mask) out += static_cast<std::uint64_t>(std::popcount(std::to_integer<unsigned>(byte)));
  return out;
}

void VdbLengths::valuesOfNode(std::uint64_t slots, std::uint64_t children, std::uint64_t active, const Values& values) {
  const std::uint64_t value_bytes = bytesOfType(values.type);
  const bool flagged = version_ >= kCompressedGrids;
  const std::uint32_t compression = flagged ? grid_compression_ : values.compression;
  std::uint64_t count = flagged ? slots : slots - children;
  if (flagged) {
    // Kinds 2 and 4 store one inactive value, kind 5 two; kinds 3 to 5 store a mask of inactive values; kind 6 stores
    // all values.
    const auto kind = take<std::uint8_t>();
    skip(value_bytes * (kind == 5 ? 2 : kind == 2 || kind == 4 ? 1 : 0));
    if (kind >= 3 && kind <= 5) skip(slots / 8);
    if ((compression & kActiveOnly) != 0 && kind != 6) count = active;
  }
  const std::uint64_t shorter = values.half ? halfShortens(values.type) : 1;
  if (shorter > 1 && count == 0) return;
  valuesIn(count * value_bytes / shorter, compression);
}

// Walks values that have `bytes` bytes without compression.
void VdbLengths::valuesIn(std::uint64_t bytes, std::uint32_t compression) {
  if ((compression & (kZip | kBlosc)) == 0) return skip(bytes);
  const std::uint64_t at = at_;
  // A positive number is the compressed length; a negative one is the length of uncompressed values.
  const auto packed = take<std::int64_t>();
  const std::uint64_t length = packed > 0 ? static_cast<std::uint64_t>(packed) : 0 - static_cast<std::uint64_t>(packed);
  if (packed <= 0 ? length != bytes : length > kMostPacking * bytes + kPackingHead)
    fail(at, fmt::format("values of {} bytes have a stored length of {}", bytes, packed));
  skip(length);
  if (packed > 0)
    packed_.push_back({at, static_cast<std::uint32_t>(bytes),
                       (compression & kBlosc) != 0 ? VdbPacked::Kind::kBlosc : VdbPacked::Kind::kZip});
}

}  // namespace kiln
