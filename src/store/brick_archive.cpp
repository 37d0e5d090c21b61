#include "store/brick_archive.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#ifdef OPENVDB_USE_DELAYED_LOADING
#include <openvdb/io/DelayedLoadMetadata.h>
#endif

#include <algorithm>
#include <cstring>

namespace kiln {
namespace {

constexpr std::uint32_t kCompression = openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK;
// Only the values of active voxels follow; the others have the background's.
constexpr char kActiveValuesOnly = openvdb::io::NO_MASK_OR_INACTIVE_VALS;

void put(std::ostream& out, const void* data, std::size_t bytes) {
  out.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
}

void noteLengths([[maybe_unused]] const PackedGrid& packed) {
#ifdef OPENVDB_USE_DELAYED_LOADING
  const std::span<const std::int64_t> lengths = packed.leaves.lengths();
  if (lengths.empty()) return;
  openvdb::io::DelayedLoadMetadata note;
  note.resizeMask(lengths.size());
  note.resizeCompressedSize(lengths.size());
  for (std::size_t i = 0; i < lengths.size(); ++i) {
    note.setMask(i, kActiveValuesOnly);
    note.setCompressedSize(i, lengths[i]);
  }
  packed.grid->insertMeta(openvdb::GridBase::META_FILE_DELAYED_LOAD, note);
#endif
}

// What Archive::write does, with the leaves' values as they come.
class PackedArchive : public openvdb::io::Archive {
 public:
  PackedArchive() { setCompression(kCompression); }

  void writeTo(std::ostream& out, std::span<const PackedGrid> grids, const openvdb::MetaMap& metadata) const {
    openvdb::SharedPtr<openvdb::io::StreamMetadata> stream(new openvdb::io::StreamMetadata);
    openvdb::io::setStreamMetadataPtr(out, stream, /*transfer=*/false);
    writeHeader(out, /*seekable=*/true);
    metadata.writeMeta(out);
    const auto count = static_cast<std::int32_t>(grids.size());
    put(out, &count, sizeof count);
    for (const PackedGrid& packed : grids) writePacked(out, packed);
    openvdb::io::clearStreamMetadataPtr(out);
  }

 private:
  void writePacked(std::ostream& out, const PackedGrid& packed) const {
    openvdb::GridBase& grid = *packed.grid;
    openvdb::io::GridDescriptor descriptor(grid.getName(), grid.type(), grid.saveFloatAsHalf());
    descriptor.writeHeader(out);
    const std::streampos offsets_at = out.tellp();
    descriptor.writeStreamPos(out);  // to be written again when they are known
    descriptor.setGridPos(out.tellp());
    setGridCompression(out, grid);
    noteLengths(packed);
    grid.writeMeta(out);
    grid.writeTransform(out);
    grid.writeTopology(out);
    descriptor.setBlockPos(out.tellp());
    put(out, packed.leaves.bytes().data(), packed.leaves.bytes().size());
    descriptor.setEndPos(out.tellp());
    out.seekp(offsets_at);
    descriptor.writeStreamPos(out);
    descriptor.seekToEnd(out);
  }
};

}  // namespace

std::streamsize MemoryWriter::xsputn(const char* from, std::streamsize count) {
  const auto bytes = static_cast<std::size_t>(count);
  const std::size_t over = std::min(bytes, data_.size() - at_);
  if (over > 0) std::memcpy(data_.data() + at_, from, over);
  const auto* const rest = reinterpret_cast<const std::byte*>(from) + over;
  data_.insert(data_.end(), rest, rest + (bytes - over));
  at_ += bytes;
  return count;
}

MemoryWriter::int_type MemoryWriter::overflow(int_type c) {
  const char byte = traits_type::to_char_type(c);
  return xsputn(&byte, 1) == 1 ? c : traits_type::eof();
}

MemoryWriter::pos_type MemoryWriter::seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) {
  const auto base = from == std::ios_base::beg ? 0 : from == std::ios_base::cur ? at_ : data_.size();
  at_ = static_cast<std::size_t>(static_cast<off_type>(base) + offset);
  return static_cast<pos_type>(static_cast<off_type>(at_));
}

MemoryWriter::pos_type MemoryWriter::seekpos(pos_type position, std::ios_base::openmode) {
  at_ = static_cast<std::size_t>(static_cast<off_type>(position));
  return position;
}

void PackedLeaves::add(const openvdb::util::NodeMask<3>& active, const void* values, std::size_t value_bytes,
                       std::size_t count) {
  active.save(out_);
  out_.put(kActiveValuesOnly);
  const std::size_t before = buffer_.data().size();
  openvdb::io::bloscToStream(out_, static_cast<const char*>(values), value_bytes, count);
  lengths_.push_back(static_cast<std::int64_t>(buffer_.data().size() - before));
}

void PackedLeaves::reserve(std::size_t leaves, std::size_t value_bytes) {
  constexpr std::size_t kMaskAndLengths = 128;
  buffer_.reserve(leaves * (openvdb::FloatTree::LeafNodeType::SIZE * value_bytes + kMaskAndLengths));
  lengths_.reserve(leaves);
}

std::vector<std::byte> archiveOf(std::span<const PackedGrid> grids, const openvdb::MetaMap& metadata) {
  MemoryWriter buffer;
  std::size_t bytes = 1 << 16;
  for (const PackedGrid& packed : grids) bytes += packed.leaves.bytes().size() + 96 * packed.leaves.lengths().size();
  buffer.reserve(bytes);
  std::ostream out(&buffer);
  PackedArchive().writeTo(out, grids, metadata);
  return buffer.take();
}

}  // namespace kiln
