#include "ingest/hdf5/hdf5_chunks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "ingest/chunks/chunk_voxels.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

/// The layout that both ways of reading share.
class Hdf5Chunks : public ChunkedArray {
 public:
  Hdf5Chunks(const fs::path& file, Hdf5Layout layout)
      : ChunkedArray(layout), path_(file), layout_(std::move(layout)), chunk_voxels_(productOf(layout_.chunk_shape)) {}

  const ChunkLayout& layout() const override { return layout_; }
  std::uint64_t heldBytes() const override { return layout_.table.size() * sizeof(hdf5::ChunkEntry); }

 protected:
  std::uint64_t storedBytes() const { return chunk_voxels_ * layout_.number.bytes(); }
  std::uint64_t voxelBytes() const { return chunk_voxels_ * sizeOf(layout_.number.voxelType()); }

  fs::path path_;
  Hdf5Layout layout_;
  std::uint64_t chunk_voxels_;
};

/// Chunks whose places and codecs are known.
class PlacedChunks : public Hdf5Chunks {
 public:
  PlacedChunks(const fs::path& file, Hdf5Layout layout) : Hdf5Chunks(file, std::move(layout)), file_(file) {
    codecsWithout(0);
  }

  std::uint64_t decodeBytes() const override { return decodeVoxelsBytes(codecs_.at(0), layout_.number, chunk_voxels_); }

 private:
  BlockCache::Bytes decode(const AxisNumbers&, std::int64_t place, BlockCache::Bytes spare) override {
    const hdf5::ChunkEntry& entry = layout_.table[static_cast<std::size_t>(place)];
    const ChunkPlace at{path_, fmt::format("{}: chunk {}", layout_.path, place)};
    if (entry.address == UINT64_MAX) {
      if (!layout_.fill_fault.empty()) at.fail(layout_.fill_fault);
      return {};
    }
    const CodecChain& codecs = codecsWithout(entry.left_out);
    const std::uint64_t most = codecs.packedBytes(storedBytes());
    if (entry.bytes == 0 || entry.bytes > most)
      at.fail(
          fmt::format("has {} bytes, and a chunk of {} bytes has 1 to {} packed", entry.bytes, storedBytes(), most));
    if (entry.address > file_.size() || entry.bytes > file_.size() - entry.address)
      at.fail(
          fmt::format("lies at byte {} with {} bytes, but the file has {}", entry.address, entry.bytes, file_.size()));
    std::vector<std::byte> packed(entry.bytes);
    file_.readAt(entry.address, packed);
    BlockCache::Bytes out = std::move(spare);
    out.resize(voxelBytes());
    decodeVoxels(codecs, layout_.number, packed, out, at);
    return out;
  }

  // Writers leave out a filter that saves nothing, chunk by chunk.
  const CodecChain& codecsWithout(std::uint64_t left_out) {
    left_out &= (std::uint64_t{1} << layout_.filters.size()) - 1;
    const std::scoped_lock lock(mutex_);
    const auto found = codecs_.find(left_out);
    if (found != codecs_.end()) return found->second;
    return codecs_.emplace(left_out, *codecsOf(layout_.filters, left_out, layout_.number.bytes())).first->second;
  }

  File file_;
  std::mutex mutex_;
  std::map<std::uint64_t, CodecChain> codecs_;
};

/// Chunks that the HDF5 library reads, in a process for each thread that reads.
class ServedChunks : public Hdf5Chunks {
 public:
  using Hdf5Chunks::Hdf5Chunks;

  // The process holds a chunk packed, unpacked and as voxels, too. Measured: 2.8 MiB of its own memory.
  std::uint64_t decodeBytes() const override {
    constexpr std::uint64_t kProcessBytes = 4 << 20;
    return 3 * storedBytes() + 2 * voxelBytes() + kProcessBytes;
  }

 private:
  BlockCache::Bytes decode(const AxisNumbers& index, std::int64_t, BlockCache::Bytes spare) override {
    const ChunkPlace at{path_, layout_.path};
    std::string payload = layout_.path + '\0';
    AxisNumbers n(index.size());
    for (std::size_t axis = 0; axis < index.size(); ++axis) {
      const std::int64_t first = index[axis] * layout_.chunk_shape[axis],
                         end = std::min(first + layout_.chunk_shape[axis], layout_.shape[axis]);
      n[axis] = end - first;
      for (const std::int64_t number : {first, end})
        payload.append(reinterpret_cast<const char*>(&number), sizeof number);
    }
    BlockCache::Bytes part = std::move(spare);
    part.resize(productOf(n) * sizeOf(layout_.number.voxelType()));
    readVoxels(layout_.number, part, at, [&](std::span<std::byte> stored) {
      const auto reader = readers_.take(
          0, [&] { return std::make_unique<Hdf5Reader>(path_, kReaderAddressBytes + 8 * storedBytes()); });
      reader->read(payload, stored);
    });
    return n == layout_.chunk_shape ? part : wholeChunk(layout_, part, n);
  }

  HandlePool<Hdf5Reader> readers_;
};

}  // namespace

std::unique_ptr<ChunkedArray> openHdf5Chunks(const fs::path& file, Hdf5Layout layout) {
  if (!layout.table.empty()) return std::make_unique<PlacedChunks>(file, std::move(layout));
  layout.number = layout.served;
  return std::make_unique<ServedChunks>(file, std::move(layout));
}

}  // namespace kiln
