#include "store/codec/brick_archive.h"

#include <openvdb/io/Archive.h>
#include <openvdb/io/GridDescriptor.h>
#ifdef OPENVDB_USE_DELAYED_LOADING
#include <openvdb/io/DelayedLoadMetadata.h>
#endif

#include <algorithm>
#include <array>
#include <cstring>

#include "grid/openvdb_glue.h"
#include "store/codec/leaf_frame.h"

namespace kiln {
namespace {

constexpr std::uint32_t kCompression = openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK;
// Only values of active voxels are stored; inactive voxels have the background value.
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

// Returns the leading leaves of `from` that lie in one node, 2^log2_edge voxels wide.
std::span<const PackedLeaves::Leaf> leavesOfNode(std::span<const PackedLeaves::Leaf> from, openvdb::Index log2_edge) {
  const auto nodeOf = [&](const PackedLeaves::Leaf& leaf) { return leaf.origin >> log2_edge; };
  std::size_t count = 1;
  while (count < from.size() && nodeOf(from[count]) == nodeOf(from[0])) ++count;
  return from.first(count);
}

// Calls f(leaves) for each node of this width.
template <class F>
void forNodes(std::span<const PackedLeaves::Leaf> leaves, openvdb::Index log2_edge, F&& f) {
  while (!leaves.empty()) {
    const auto of_node = leavesOfNode(leaves, log2_edge);
    f(of_node);
    leaves = leaves.subspan(of_node.size());
  }
}

// Writes the topology of a tree without tiles, as Tree::writeTopology does. Each inner node is a mask of its children,
// an empty mask of active values, and no values; each leaf is a mask.
class TopologyWriter {
 public:
  TopologyWriter(std::ostream& out, std::size_t value_bytes, bool as_half)
      : out_(out), value_bytes_(value_bytes), half_(as_half) {}

  void write(std::span<const PackedLeaves::Leaf> leaves) const {
    const std::int32_t buffers = 1;
    put(out_, &buffers, sizeof buffers);
    const std::array<char, 8> background{};
    put(out_, background.data(), value_bytes_);
    const openvdb::Index32 tiles = 0;
    openvdb::Index32 children = 0;
    forNodes(leaves, Upper::TOTAL, [&](auto) { ++children; });
    put(out_, &tiles, sizeof tiles);
    put(out_, &children, sizeof children);
    forNodes(leaves, Upper::TOTAL, [&](std::span<const PackedLeaves::Leaf> of_upper) {
      const openvdb::Coord origin = (of_upper[0].origin >> Upper::TOTAL) << Upper::TOTAL;
      put(out_, origin.asPointer(), 3 * sizeof(openvdb::Int32));
      writeNode<Upper>(of_upper, Lower::TOTAL);
      forNodes(of_upper, Lower::TOTAL, [&](std::span<const PackedLeaves::Leaf> of_lower) {
        writeNode<Lower>(of_lower, openvdb::FloatTree::LeafNodeType::TOTAL);
        for (const PackedLeaves::Leaf& leaf : of_lower) leaf.active.save(out_);
      });
    });
  }

 private:
  using Upper = openvdb::FloatTree::RootNodeType::ChildNodeType;
  using Lower = Upper::ChildNodeType;

  template <class Node>
  void writeNode(std::span<const PackedLeaves::Leaf> leaves, openvdb::Index log2_child) const {
    typename Node::NodeMaskType children, active;
    forNodes(leaves, log2_child, [&](std::span<const PackedLeaves::Leaf> of_child) {
      children.setOn(Node::coordToOffset(of_child[0].origin));
    });
    children.save(out_);
    active.save(out_);
    put(out_, &kActiveValuesOnly, sizeof kActiveValuesOnly);
    if (!half_) openvdb::io::bloscToStream(out_, nullptr, value_bytes_, 0);
  }

  std::ostream& out_;
  const std::size_t value_bytes_;
  const bool half_;
};

// A stream that compares the written bytes with expected bytes.
class Matcher : public std::streambuf {
 public:
  explicit Matcher(std::span<const std::byte> expected) : expected_(expected) {}
  /// Number of equal bytes; 0 if a byte differs or is missing.
  std::size_t matched() const { return same_ ? at_ : 0; }

 protected:
  std::streamsize xsputn(const char* from, std::streamsize count) override {
    const auto bytes = static_cast<std::size_t>(count);
    same_ = same_ && bytes <= expected_.size() - at_ && std::memcmp(expected_.data() + at_, from, bytes) == 0;
    at_ += same_ ? bytes : 0;
    return count;
  }
  int_type overflow(int_type c) override {
    const char byte = traits_type::to_char_type(c);
    xsputn(&byte, 1);
    return c;
  }

 private:
  const std::span<const std::byte> expected_;
  std::size_t at_ = 0;
  bool same_ = true;
};

// Writes the file as Archive::write does, with packed leaf values.
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
    descriptor.writeStreamPos(out);  // overwritten when the offsets are known
    descriptor.setGridPos(out.tellp());
    setGridCompression(out, grid);
    noteLengths(packed);
    grid.writeMeta(out);
    grid.writeTransform(out);
    TopologyWriter(out, packed.leaves.valueBytes(), grid.saveFloatAsHalf()).write(packed.leaves.leaves());
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

PackedLeaves::PackedLeaves(std::size_t most, std::size_t value_bytes)
    : value_bytes_(value_bytes),
      data_(std::make_unique_for_overwrite<std::byte[]>(most * (Mask::SIZE * value_bytes + Mask::memUsage() +
                                                                sizeof kActiveValuesOnly + sizeof(std::int64_t) +
                                                                kFrameOverhead_bytes))) {
  leaves_.reserve(most);
  lengths_.reserve(most);
}

void PackedLeaves::append(const void* from, std::size_t bytes) {
  std::memcpy(data_.get() + size_, from, bytes);
  size_ += bytes;
}

void PackedLeaves::add(const Leaf& leaf, const void* values, std::size_t stored_bytes, std::size_t count) {
  leaves_.push_back(leaf);
  std::array<Mask::Word, Mask::WORD_COUNT> words;
  for (openvdb::Index i = 0; i < Mask::WORD_COUNT; ++i) words[i] = leaf.active.getWord<Mask::Word>(i);
  append(words.data(), sizeof words);
  append(&kActiveValuesOnly, sizeof kActiveValuesOnly);
  // Equals openvdb::io::bloscToStream, without Blosc.
  const std::size_t before = size_;
  const std::size_t packed = packLeaf(values, stored_bytes * count, data_.get() + size_ + sizeof(std::int64_t));
  const auto length = static_cast<std::int64_t>(packed);
  append(&length, sizeof length);
  size_ += packed;
  lengths_.push_back(static_cast<std::int64_t>(size_ - before));
}

std::size_t matchTopology(std::span<const std::byte> file, std::span<const PackedLeaves::Leaf> leaves,
                          std::size_t value_bytes, bool as_half) {
  Matcher matcher(file);
  std::ostream out(&matcher);
  TopologyWriter(out, value_bytes, as_half).write(leaves);
  return matcher.matched();
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
