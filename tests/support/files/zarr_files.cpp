#include "support/files/zarr_files.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <numeric>

#include "support/files/packed_bytes.h"

namespace kiln::test {
namespace fs = std::filesystem;
namespace {

using Numbers = std::vector<std::int64_t>;

constexpr const char* kNumPyTypes[] = {"u1", "i1", "u2", "i2", "u4", "i4", "f4", "f8"};
constexpr const char* kTypeNames[] = {"uint8", "int8", "uint16", "int16", "uint32", "int32", "float32", "float64"};

Numbers along(const ZarrLayout& layout, const std::function<std::int64_t(const ZarrTestAxis&)>& number) {
  Numbers out;
  for (const ZarrTestAxis& axis : layout.axes) out.push_back(number(axis));
  return out;
}

Numbers shapeOf(const ForeignVolume& volume, const ZarrLayout& layout) {
  const Extent3& n = volume.dims;
  return along(layout, [&](const ZarrTestAxis& axis) {
    return axis.name == 'x' ? n.x : axis.name == 'y' ? n.y : axis.name == 'z' ? n.z : axis.count;
  });
}

Numbers chunkOf(const ZarrLayout& layout) {
  return along(layout, [](const ZarrTestAxis& axis) { return axis.chunk; });
}

std::vector<int> storedAxes(const ZarrLayout& layout) {
  std::vector<int> out = layout.stored_axes;
  out.resize(layout.axes.size());
  if (layout.stored_axes.empty()) std::iota(out.begin(), out.end(), 0);
  return out;
}

// Calls visit(index) for all indices below `counts`; the axis that `order` names last is the fastest.
void forEachIndex(const Numbers& counts, const std::vector<int>& order,
                  const std::function<void(const Numbers&)>& visit) {
  if (std::find(counts.begin(), counts.end(), 0) != counts.end()) return;
  Numbers index(counts.size(), 0);
  while (true) {
    visit(index);
    std::size_t at = order.size();
    for (; at > 0; --at) {
      const auto axis = static_cast<std::size_t>(order[at - 1]);
      if (++index[axis] < counts[axis]) break;
      index[axis] = 0;
    }
    if (at == 0) return;
  }
}

std::vector<int> plainOrder(std::size_t axes) {
  std::vector<int> out(axes);
  std::iota(out.begin(), out.end(), 0);
  return out;
}

std::string packed(std::string_view bytes, const ZarrLayout& layout, std::size_t number_bytes) {
  switch (layout.codec) {
    case ZarrCodec::kRaw:
      break;
    case ZarrCodec::kGzip:
      return gzipped(bytes);
    case ZarrCodec::kZlib:
      return zlibbed(bytes);
    case ZarrCodec::kZstd:
      return zstdFrame(bytes);
    case ZarrCodec::kLz4:
      return layout.version == ZarrVersion::kN5 ? lz4Stream(bytes, 48) : sizedLz4(bytes);
    case ZarrCodec::kBzip2:
      return bzipped(bytes);
    case ZarrCodec::kXz:
      return xzStream(bytes);
    case ZarrCodec::kBlosc:
      return bloscFrame(bytes, {.shuffle = 1, .number_bytes = number_bytes});
  }
  return std::string(bytes);
}

class Writer {
 public:
  Writer(const ForeignVolume& volume, const ZarrLayout& layout)
      : volume_(volume),
        layout_(layout),
        size_(sizeOf(volume.type)),
        stored_(volume.stored(layout.big_endian || layout.version == ZarrVersion::kN5)),
        shape_(shapeOf(volume, layout)),
        chunk_(chunkOf(layout)) {}

  void write(const fs::path& folder) const {
    const std::int64_t in_shard = std::max<std::int64_t>(layout_.chunks_in_shard, 1);
    Numbers files;
    for (std::size_t axis = 0; axis < shape_.size(); ++axis)
      files.push_back((shape_[axis] + chunk_[axis] * in_shard - 1) / (chunk_[axis] * in_shard));
    forEachIndex(files, plainOrder(files.size()), [&](const Numbers& file) {
      const std::string bytes = layout_.chunks_in_shard > 0 ? shard(file) : chunk(file);
      if (!bytes.empty()) writeBelow(folder / nameOf(file), bytes);
    });
  }

 private:
  // The bytes of a voxel; `fill_byte` beyond the array.
  std::string voxel(const Numbers& index) const {
    VoxelCoord at;
    bool chosen = true;
    for (std::size_t axis = 0; axis < index.size(); ++axis) {
      const ZarrTestAxis& of = layout_.axes[axis];
      if (index[axis] >= shape_[axis]) return std::string(size_, layout_.fill_byte);
      if (of.name == 'x' || of.name == 'y' || of.name == 'z')
        at[of.name - 'x'] = index[axis];
      else
        chosen = chosen && index[axis] == of.index;
    }
    const std::int64_t place = (at.z * volume_.dims.y + at.y) * volume_.dims.x + at.x;
    std::string out = stored_.substr(static_cast<std::size_t>(place) * size_, size_);
    if (!chosen)
      for (char& byte : out) byte = static_cast<char>(~byte);
    return out;
  }

  // Empty for a chunk that is left out.
  std::string chunk(const Numbers& number) const {
    Numbers counts = chunk_, first(number.size());
    for (std::size_t axis = 0; axis < number.size(); ++axis) {
      first[axis] = number[axis] * chunk_[axis];
      // N5 cuts blocks at the border of the array.
      if (layout_.version == ZarrVersion::kN5) counts[axis] = std::min(counts[axis], shape_[axis] - first[axis]);
      if (first[axis] >= shape_[axis]) return "";
    }
    std::string bytes;
    forEachIndex(counts, storedAxes(layout_), [&](Numbers index) {
      for (std::size_t axis = 0; axis < index.size(); ++axis) index[axis] += first[axis];
      bytes += voxel(index);
    });
    if (layout_.fill != "null" && bytes.find_first_not_of(layout_.fill_byte) == std::string::npos) return "";
    std::string out = packed(bytes, layout_, size_);
    if (layout_.checksum) out = withCrc32c(out);
    return layout_.version == ZarrVersion::kN5 ? blockHeader(counts) + out : out;
  }

  static std::string blockHeader(const Numbers& counts) {
    std::string out = bigEndian(0, 2) + bigEndian(counts.size(), 2);
    for (auto count = counts.rbegin(); count != counts.rend(); ++count)
      out += bigEndian(static_cast<std::uint64_t>(*count), 4);
    return out;
  }

  std::string shard(const Numbers& number) const {
    const Numbers counts(number.size(), layout_.chunks_in_shard);
    std::size_t entries = 1;
    for (const std::int64_t count : counts) entries *= static_cast<std::size_t>(count);
    const std::size_t index_bytes = 16 * entries + 4;
    std::string table, data;
    forEachIndex(counts, plainOrder(counts.size()), [&](Numbers inner) {
      for (std::size_t axis = 0; axis < inner.size(); ++axis) inner[axis] += number[axis] * layout_.chunks_in_shard;
      const std::string bytes = chunk(inner);
      const std::size_t start = layout_.index_at_start ? index_bytes : 0;
      table += bytes.empty() ? std::string(16, '\xff')
                             : littleEndian(start + data.size(), 8) + littleEndian(bytes.size(), 8);
      data += bytes;
    });
    if (data.empty()) return "";
    return layout_.index_at_start ? withCrc32c(table) + data : data + withCrc32c(table);
  }

  fs::path nameOf(const Numbers& number) const {
    Numbers parts = number;
    if (layout_.version == ZarrVersion::kN5) std::reverse(parts.begin(), parts.end());
    const char by_default = layout_.version == ZarrVersion::kTwo ? '.' : '/';
    const std::string separator(1, layout_.separator != '\0' ? layout_.separator : by_default);
    return (layout_.version == ZarrVersion::kThree ? "c" + separator : "") +
           fmt::format("{}", fmt::join(parts, separator));
  }

  const ForeignVolume& volume_;
  const ZarrLayout& layout_;
  std::size_t size_;
  std::string stored_;
  Numbers shape_, chunk_;
};

std::string listOf(const Numbers& numbers) { return fmt::format("[{}]", fmt::join(numbers, ", ")); }

std::string headerOfTwo(const ForeignVolume& volume, const ZarrLayout& layout) {
  constexpr const char* kCompressors[] = {
      "null",
      R"({"id": "gzip", "level": 6})",
      R"({"id": "zlib", "level": 6})",
      R"({"id": "zstd", "level": 3})",
      R"({"id": "lz4", "acceleration": 1})",
      R"({"id": "blosc", "cname": "lz4", "clevel": 5, "shuffle": 1, "blocksize": 0})",
      R"({"id": "bz2", "level": 1})",
      R"({"id": "lzma", "format": 1, "check": -1, "preset": null, "filters": null})"};
  const char order = sizeOf(volume.type) == 1 ? '|' : layout.big_endian ? '>' : '<';
  const std::string separator =
      layout.separator == '\0' ? "" : fmt::format(R"(, "dimension_separator": "{}")", layout.separator);
  return fmt::format(
      R"({{"zarr_format": 2, "shape": {}, "chunks": {}, "dtype": "{}{}", "compressor": {}, "fill_value": {},)"
      R"( "order": "{}", "filters": null{}{}}})",
      listOf(shapeOf(volume, layout)), listOf(chunkOf(layout)), order, kNumPyTypes[static_cast<int>(volume.type)],
      kCompressors[static_cast<int>(layout.codec)], layout.fill, layout.stored_axes.empty() ? 'C' : 'F', separator,
      layout.more);
}

std::string codecsOfThree(const ZarrLayout& layout) {
  constexpr const char* kCodecs[] = {"",
                                     R"(, {"name": "gzip", "configuration": {"level": 6}})",
                                     R"(, {"name": "numcodecs.zlib", "configuration": {"level": 6}})",
                                     R"(, {"name": "zstd", "configuration": {"level": 3, "checksum": false}})",
                                     R"(, {"name": "numcodecs.lz4", "configuration": {"acceleration": 1}})",
                                     R"(, {"name": "blosc", "configuration": {"cname": "lz4", "clevel": 5,)"
                                     R"( "shuffle": "shuffle", "typesize": 2, "blocksize": 0}})",
                                     R"(, {"name": "numcodecs.bz2", "configuration": {"level": 1}})",
                                     R"(, {"name": "numcodecs.lzma", "configuration": {"preset": 6}})"};
  std::string out;
  if (!layout.stored_axes.empty())
    out = fmt::format(R"({{"name": "transpose", "configuration": {{"order": [{}]}}}}, )",
                      fmt::join(layout.stored_axes, ", "));
  out +=
      fmt::format(R"({{"name": "bytes", "configuration": {{"endian": "{}"}}}})", layout.big_endian ? "big" : "little");
  out += kCodecs[static_cast<int>(layout.codec)];
  return out + (layout.checksum ? R"(, {"name": "crc32c"})" : "");
}

std::string headerOfThree(const ForeignVolume& volume, const ZarrLayout& layout) {
  std::string codecs = codecsOfThree(layout), names;
  Numbers file = chunkOf(layout);
  if (layout.chunks_in_shard > 0) {
    codecs = fmt::format(R"({{"name": "sharding_indexed", "configuration": {{"chunk_shape": {}, "codecs": [{}],)"
                         R"( "index_codecs": [{{"name": "bytes", "configuration": {{"endian": "little"}}}},)"
                         R"( {{"name": "crc32c"}}], "index_location": "{}"}}}})",
                         listOf(file), codecs, layout.index_at_start ? "start" : "end");
    for (std::int64_t& length : file) length *= layout.chunks_in_shard;
  }
  for (const ZarrTestAxis& axis : layout.axes) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", axis.name);
  const std::string separator =
      layout.separator == '\0' ? "" : fmt::format(R"(, "configuration": {{"separator": "{}"}})", layout.separator);
  return fmt::format(
      R"({{"zarr_format": 3, "node_type": "array", "shape": {}, "data_type": "{}", "fill_value": {}, "codecs": [{}],)"
      R"( "chunk_grid": {{"name": "regular", "configuration": {{"chunk_shape": {}}}}},)"
      R"( "chunk_key_encoding": {{"name": "default"{}}}{}{}}})",
      listOf(shapeOf(volume, layout)), kTypeNames[static_cast<int>(volume.type)], layout.fill, codecs, listOf(file),
      separator, layout.names_axes ? ", \"dimension_names\": [" + names + "]" : "", layout.more);
}

std::string headerOfN5(const ForeignVolume& volume, const ZarrLayout& layout) {
  constexpr const char* kCompressions[] = {R"({"type": "raw"})",
                                           R"({"type": "gzip", "level": -1, "useZlib": false})",
                                           R"({"type": "gzip", "level": 5, "useZlib": true})",
                                           R"({"type": "zstd", "level": 3})",
                                           R"({"type": "lz4", "blockSize": 65536})",
                                           R"({"type": "blosc", "cname": "lz4", "shuffle": 1})",
                                           R"({"type": "bzip2", "blockSize": 9})",
                                           R"({"type": "xz", "preset": 6})"};
  Numbers shape = shapeOf(volume, layout), chunk = chunkOf(layout);
  std::reverse(shape.begin(), shape.end());
  std::reverse(chunk.begin(), chunk.end());
  return fmt::format(R"({{"dimensions": {}, "blockSize": {}, "dataType": "{}", "compression": {}{}}})", listOf(shape),
                     listOf(chunk), kTypeNames[static_cast<int>(volume.type)],
                     kCompressions[static_cast<int>(layout.codec)], layout.more);
}

}  // namespace

void writeBelow(const fs::path& path, std::string_view bytes) {
  fs::create_directories(path.parent_path());
  writeAnew(path, bytes);
}

const char* zarrHeaderName(ZarrVersion version) {
  return version == ZarrVersion::kTwo ? ".zarray" : version == ZarrVersion::kThree ? "zarr.json" : "attributes.json";
}

std::string zarrHeader(const ForeignVolume& volume, const ZarrLayout& layout) {
  switch (layout.version) {
    case ZarrVersion::kTwo:
      return headerOfTwo(volume, layout);
    case ZarrVersion::kThree:
      return headerOfThree(volume, layout);
    case ZarrVersion::kN5:
      break;
  }
  return headerOfN5(volume, layout);
}

fs::path writeZarr(const fs::path& folder, const ForeignVolume& volume, const ZarrLayout& layout) {
  writeBelow(folder / zarrHeaderName(layout.version), zarrHeader(volume, layout));
  Writer(volume, layout).write(folder);
  return folder;
}

}  // namespace kiln::test
