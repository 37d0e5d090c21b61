#include "store/brick_index.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include "base/byte_record.h"
#include "base/error.h"

namespace kiln {
namespace {

static_assert(std::endian::native == std::endian::little, "index.bin is little-endian and copied as it is");

// The last digit is the format: format 1 has no sub-ranges; format 2 has fewer, and its entries do not hold their
// number.
constexpr char kIndexMagic[8] = {'K', 'I', 'L', 'N', 'I', 'D', 'X', '3'};
constexpr char kFirstDigit = '1';
constexpr std::uint32_t kConstantFlag = 1, kSubRangesFlag = 2;

// The 64 bytes of an entry (FORMAT.md, index.bin).
struct RawEntry {
  std::uint32_t flags, sub_bricks;
  double core_min, core_max, support_min, support_max;
  std::uint64_t file_bytes;
  std::uint8_t checksum[16];
};
static_assert(sizeof(RawEntry) == 64);

// True if so many bytes can hold an entry per brick. Tested before memory is allocated for the lattices of a manifest.
bool haveRoom(std::uint64_t bytes, const std::vector<Extent3>& lattices) {
  std::uint64_t entries = bytes / sizeof(RawEntry);
  for (const Extent3& lattice : lattices) {
    std::uint64_t count = 1;
    for (int axis = 0; axis < 3; ++axis) {
      if (static_cast<std::uint64_t>(lattice[axis]) > entries / count) return false;
      count *= static_cast<std::uint64_t>(lattice[axis]);
    }
    entries -= count;
  }
  return true;
}

}  // namespace

void appendEntry(std::vector<std::byte>& out, const BrickEntry& entry) {
  RawEntry raw{(entry.constant ? kConstantFlag : 0) | (entry.sub_ranges ? kSubRangesFlag : 0),
               static_cast<std::uint32_t>(entry.sub_ranges ? entry.sub_ranges->along() : 0),
               entry.core.lo,
               entry.core.hi,
               entry.support.lo,
               entry.support.hi,
               entry.file_bytes,
               {}};
  std::memcpy(raw.checksum, entry.checksum.bytes.data(), sizeof raw.checksum);
  appendValue(out, raw);
  if (!entry.sub_ranges) return;
  const std::span<const std::byte> ranges = entry.sub_ranges->bytes();
  out.insert(out.end(), ranges.begin(), ranges.end());
}

std::optional<BrickEntry> takeEntry(std::span<const std::byte>& bytes) {
  RawEntry raw;
  if (bytes.size() < sizeof raw) return std::nullopt;
  std::memcpy(&raw, bytes.data(), sizeof raw);
  BrickEntry entry;
  entry.constant = (raw.flags & kConstantFlag) != 0;
  entry.core = {raw.core_min, raw.core_max};
  entry.support = {raw.support_min, raw.support_max};
  entry.file_bytes = raw.file_bytes;
  std::memcpy(entry.checksum.bytes.data(), raw.checksum, sizeof raw.checksum);
  std::size_t taken = sizeof raw;
  if ((raw.flags & kSubRangesFlag) != 0) {
    const std::uint32_t along = raw.sub_bricks == 0 ? kEarlierSubBricks : raw.sub_bricks;
    if (along > kMostSubBricks) return std::nullopt;
    const std::size_t size = SubRanges::bytesOf(static_cast<int>(along));
    if (bytes.size() < taken + size) return std::nullopt;
    entry.sub_ranges = std::make_shared<const SubRanges>(static_cast<int>(along), bytes.subspan(taken, size));
    taken += size;
  }
  bytes = bytes.subspan(taken);
  return entry;
}

BrickIndex::BrickIndex(std::vector<Extent3> lattices) : lattices_(std::move(lattices)) {
  std::size_t total = 0;
  for (const Extent3& lattice : lattices_) {
    first_.push_back(total);
    total += static_cast<std::size_t>(lattice.count());
  }
  entries_.resize(total);
}

bool BrickIndex::contains(const BrickKey& key) const {
  if (key.level < 0 || key.level >= levels()) return false;
  return boxOf(lattice(key.level)).contains({key.brick.x, key.brick.y, key.brick.z});
}

std::size_t BrickIndex::place(const BrickKey& key) const {
  return first_[static_cast<std::size_t>(key.level)] + placeOf(lattice(key.level), key.brick);
}

// In the order of the index, so the result does not depend on the order in which entries were made.
ValueRange BrickIndex::valueRange() const {
  ValueRange out;
  for (std::int64_t i = 0; i < lattices_.front().count(); ++i) out.include(at({0, brickAt(lattices_.front(), i)}).core);
  return out;
}

std::uint64_t BrickIndex::largest(const std::function<std::uint64_t(const BrickKey&)>& bytes_of) const {
  std::uint64_t out = 0;
  forEachKey([&](const BrickKey& key) { out = std::max(out, bytes_of(key)); });
  return out;
}

std::uint64_t BrickIndex::bytes() const {
  std::uint64_t sum = entries_.size() * sizeof(BrickEntry);
  for (const BrickEntry& entry : entries_) sum += entry.sub_ranges ? subRangesBytes(entry.sub_ranges->along()) : 0;
  return sum;
}

std::uint64_t BrickIndex::bytesOf(std::uint64_t stored, std::uint64_t constant, std::int64_t brick_size) {
  return (stored + constant) * sizeof(BrickEntry) + stored * subRangesBytes(subBricksOf(brick_size));
}

// Assumes that an allocation takes 8 more bytes, at least 32, and a multiple of 16. One allocation holds the object, a
// second the bytes.
std::uint64_t BrickIndex::subRangesBytes(int along) {
  constexpr std::uint64_t kObject = 64, kLeast = 32;
  return kObject + std::max<std::uint64_t>(kLeast, (SubRanges::bytesOf(along) + 8 + 15) / 16 * 16);
}

std::uint64_t BrickIndex::fileBytes(std::uint64_t stored, std::uint64_t constant, std::int64_t brick_size) {
  return (stored + constant) * sizeof(RawEntry) + stored * SubRanges::bytesOf(subBricksOf(brick_size));
}

void BrickIndex::encode(const std::function<void(std::span<const std::byte>)>& take, const SubRangesAt& missing) const {
  constexpr std::size_t kPiece = 256 << 10;
  std::vector<std::byte> piece;
  piece.reserve(kPiece + (4 << 10));
  for (const char c : kIndexMagic) appendValue(piece, c);
  appendValue(piece, static_cast<std::uint32_t>(lattices_.size()));
  for (std::size_t level = 0; level < lattices_.size(); ++level) {
    appendValue(piece, lattices_[level]);
    const std::size_t count = static_cast<std::size_t>(lattices_[level].count());
    for (std::size_t i = first_[level]; i < first_[level] + count; ++i) {
      if (missing && !entries_[i].constant && !entries_[i].sub_ranges) {
        BrickEntry whole = entries_[i];
        whole.sub_ranges = missing(i);
        appendEntry(piece, whole);
      } else {
        appendEntry(piece, entries_[i]);
      }
      if (piece.size() < kPiece) continue;
      take(piece);
      piece.clear();
    }
  }
  take(piece);
}

std::vector<std::byte> BrickIndex::encode() const {
  std::vector<std::byte> out;
  encode([&](std::span<const std::byte> piece) { out.insert(out.end(), piece.begin(), piece.end()); });
  return out;
}

BrickIndex BrickIndex::decode(std::span<const std::byte> data, const std::vector<Extent3>& lattices,
                              const std::filesystem::path& path) {
  if (!haveRoom(data.size(), lattices))
    throw Error(ErrorCode::kFormat, path, "", "is too short for the bricks of the manifest");
  BrickIndex index(lattices);
  std::span<const std::byte> left = data;
  const auto place = [&] { return "byte " + std::to_string(data.size() - left.size()); };
  const auto endsHere = [&] { return Error(ErrorCode::kFormat, path, place(), "the index ends here"); };
  const auto take = [&](void* into, std::size_t bytes) {
    if (left.size() < bytes) throw endsHere();
    std::memcpy(into, left.data(), bytes);
    left = left.subspan(bytes);
  };
  char magic[8];
  std::uint32_t levels = 0;
  take(magic, sizeof magic);
  take(&levels, sizeof levels);
  constexpr std::size_t kDigit = sizeof magic - 1;
  const bool known = std::memcmp(magic, kIndexMagic, kDigit) == 0 && magic[kDigit] >= kFirstDigit &&
                     magic[kDigit] <= kIndexMagic[kDigit];
  if (!known || levels != lattices.size())
    throw Error(ErrorCode::kFormat, path, "byte 0", "not the index of this store");
  std::size_t next = 0;
  for (const Extent3& expected : lattices) {
    Extent3 lattice;
    take(&lattice, sizeof lattice);
    if (lattice != expected) throw Error(ErrorCode::kFormat, path, place(), "brick counts disagree with the manifest");
    for (std::int64_t i = 0; i < lattice.count(); ++i) {
      std::optional<BrickEntry> entry = takeEntry(left);
      if (!entry) throw endsHere();
      index.entries_[next++] = *std::move(entry);
    }
  }
  if (!left.empty()) throw Error(ErrorCode::kFormat, path, place(), "bytes beyond the index");
  return index;
}

}  // namespace kiln
