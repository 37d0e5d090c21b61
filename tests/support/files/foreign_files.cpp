#include "support/files/foreign_files.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <random>
#include <thread>

#include "ingest/open_source.h"
#include "support/system/sanitized.h"

namespace kiln::test {
namespace fs = std::filesystem;
namespace {

std::string deflated(std::string_view bytes, int window_bits) {
  z_stream z{};
  deflateInit2(&z, 6, Z_DEFLATED, window_bits, 8, Z_DEFAULT_STRATEGY);
  std::string out(deflateBound(&z, bytes.size()) + 64, '\0');
  z.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  z.avail_in = static_cast<uInt>(bytes.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  EXPECT_EQ(deflate(&z, Z_FINISH), Z_STREAM_END);
  out.resize(z.total_out);
  deflateEnd(&z);
  return out;
}

VoxelBox randomBox(const Extent3& dims, std::mt19937_64& random) {
  VoxelBox box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto n = static_cast<std::uint64_t>(dims[axis]);
    const auto a = static_cast<std::int64_t>(random() % n), b = static_cast<std::int64_t>(random() % n);
    // Often selects whole axes, which take separate code paths in the reader.
    const bool whole = random() % 3 == 0;
    box.lo[axis] = whole ? 0 : std::min(a, b);
    box.hi[axis] = whole ? dims[axis] : std::max(a, b) + 1;
  }
  return box;
}

// Returns a box of whole slices from `at` on, or of rows within its slice.
VoxelBox randomRun(const Extent3& dims, const VoxelCoord& at, std::mt19937_64& random) {
  const auto upTo = [&](std::int64_t n) {
    return 1 + static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n));
  };
  if (at.y == 0 && random() % 2 == 0)
    return {at, {dims.x, dims.y, at.z + upTo(std::min<std::int64_t>(dims.z - at.z, 3))}};
  return {at, {dims.x, at.y + upTo(dims.y - at.y), at.z + 1}};
}

std::vector<std::byte> readBox(VolumeSource& source, const VoxelBox& box) {
  std::vector<std::byte> out(static_cast<std::size_t>(box.count()) * sizeOf(source.info().type), std::byte{0xee});
  source.read(box, out);
  return out;
}

}  // namespace

void writeAnew(const fs::path& path, std::string_view bytes) {
  // Some file systems flush a file that is truncated and rewritten at once, but not a new file.
  fs::remove(path);
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw std::runtime_error("writing " + path.string());
}

ForeignFiles::ForeignFiles() {
  std::string name = (fs::temp_directory_path() / "kiln_foreign_XXXXXX").string();
  if (!::mkdtemp(name.data())) throw std::runtime_error("no temporary directory " + name);
  directory_ = name;
}

ForeignFiles::~ForeignFiles() {
  std::error_code ignored;
  fs::remove_all(directory_, ignored);
}

fs::path ForeignFiles::write(const std::string& name, std::string_view bytes) const {
  const fs::path path = directory_ / name;
  writeAnew(path, bytes);
  return path;
}

std::string bytesOf(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

std::string ForeignVolume::stored(bool big_endian) const {
  std::string out(reinterpret_cast<const char*>(voxels.data()), voxels.size());
  if (big_endian == (std::endian::native == std::endian::big)) return out;
  const auto size = static_cast<std::ptrdiff_t>(sizeOf(type));
  for (auto at = out.begin(); at != out.end(); at += size) std::reverse(at, at + size);
  return out;
}

std::vector<std::byte> ForeignVolume::box(const VoxelBox& box) const {
  std::vector<std::byte> out;
  const std::size_t size = sizeOf(type);
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
        const std::byte* voxel = voxels.data() + static_cast<std::size_t>((z * dims.y + y) * dims.x + x) * size;
        out.insert(out.end(), voxel, voxel + size);
      }
    }
  }
  return out;
}

ForeignVolume ForeignVolume::part(const VoxelBox& box) const { return {box.extent(), type, this->box(box)}; }

ForeignVolume ForeignVolume::slices(const std::vector<std::int64_t>& numbers) const {
  ForeignVolume out{{dims.x, dims.y, std::ssize(numbers)}, type, {}};
  for (const std::int64_t z : numbers) {
    const std::vector<std::byte> slice = box({{0, 0, z}, {dims.x, dims.y, z + 1}});
    out.voxels.insert(out.voxels.end(), slice.begin(), slice.end());
  }
  return out;
}

ForeignVolume randomVolume(const Extent3& dims, VoxelType type, std::uint64_t seed) {
  ForeignVolume out{dims, type, std::vector<std::byte>(static_cast<std::size_t>(dims.count()) * sizeOf(type))};
  std::mt19937_64 random(seed);
  withVoxelType(type, [&](auto identity) {
    using T = typename decltype(identity)::type;
    for (std::size_t i = 0; i < static_cast<std::size_t>(dims.count()); ++i) {
      const std::uint64_t bits = random();
      T value;
      std::memcpy(&value, &bits, sizeof(T));
      if constexpr (std::is_floating_point_v<T>) {
        if (!std::isfinite(value)) value = static_cast<T>(i);
      }
      if (i == 0) value = std::numeric_limits<T>::lowest();
      if (i == 1) value = std::numeric_limits<T>::max();
      std::memcpy(out.voxels.data() + i * sizeof(T), &value, sizeof(T));
    }
  });
  return out;
}

std::string gzipped(std::string_view bytes) { return deflated(bytes, MAX_WBITS + 16); }
std::string zlibbed(std::string_view bytes) { return deflated(bytes, MAX_WBITS); }
std::string deflatedAlone(std::string_view bytes) { return deflated(bytes, -MAX_WBITS); }

std::string decimalsOf(const ForeignVolume& volume, std::string_view separator) {
  std::string out;
  withVoxelType(volume.type, [&]<class T>(std::type_identity<T>) {
    for (std::size_t at = 0; at < volume.voxels.size(); at += sizeof(T)) {
      T value;
      std::memcpy(&value, &volume.voxels[at], sizeof(T));
      out += fmt::format("{}{}", value, separator);
    }
  });
  return out;
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error(fmt::format("'{}' is not in the text", from));
  return text.replace(at, from.size(), to);
}

std::vector<std::byte> readWhole(VolumeSource& source) {
  std::vector<std::byte> out = readBox(source, boxOf(source.info().geometry.dims));
  source.finish();
  return out;
}

void expectReadsBack(const ForeignVolume& volume, const std::function<std::unique_ptr<VolumeSource>()>& open,
                     std::uint64_t seed) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  const std::unique_ptr<VolumeSource> whole = open();
  ASSERT_EQ(whole->info().geometry.dims, volume.dims);
  ASSERT_EQ(whole->info().type, volume.type);
  EXPECT_TRUE(readWhole(*whole) == volume.voxels);
  std::mt19937_64 random(seed);
  const std::unique_ptr<VolumeSource> parts = open();
  if (parts->order() == ReadOrder::kAnyBox) {
    for (int i = 0; i < 40; ++i) {
      const VoxelBox box = randomBox(volume.dims, random);
      EXPECT_TRUE(readBox(*parts, box) == volume.box(box)) << "box " << i;
    }
  } else {
    for (VoxelCoord at; at.z < volume.dims.z;) {
      const VoxelBox box = randomRun(volume.dims, at, random);
      EXPECT_TRUE(readBox(*parts, box) == volume.box(box)) << "slice " << at.z << ", row " << at.y;
      at.y = box.hi.y % volume.dims.y;
      at.z = at.y == 0 ? box.hi.z : at.z;
    }
  }
  parts->finish();
}

void expectReadsBack(const ForeignVolume& volume, const fs::path& path, std::uint64_t seed) {
  expectReadsBack(
      volume, [&] { return openSource(path); }, seed);
}

void expectThreadsReadBack(const ForeignVolume& volume, VolumeSource& source) {
  std::vector<int> wrong(4, 0);
  {
    std::vector<std::jthread> threads;
    for (std::size_t t = 0; t < wrong.size(); ++t) {
      threads.emplace_back([&, t] {
        for (std::int64_t z = 0; z < volume.dims.z; ++z) {
          const VoxelBox box = {{static_cast<std::int64_t>(t), 2, z}, {33, 29, z + 1}};
          if (readBox(source, box) != volume.box(box)) ++wrong[t];
        }
      });
    }
  }
  EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

void expectRefused(const fs::path& path, ErrorCode code, const std::string& part, const SourceOptions& options) {
  SCOPED_TRACE(path);
  expectError([&] { readWhole(*openSource(path, options)); }, code, part);
}

void expectNoCutGoesUnnoticed(const ForeignVolume& volume, const ForeignFiles& files, const std::string& victim,
                              std::string_view bytes, const fs::path& open, const SourceOptions& options) {
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    files.write(victim, bytes.substr(0, length));
    try {
      const std::unique_ptr<VolumeSource> source = openSource(open, options);
      EXPECT_TRUE(readWhole(*source) == volume.voxels) << victim << " cut to " << length << " of " << bytes.size();
      EXPECT_TRUE(bytes.substr(length) == "\n" || bytes.substr(length) == "\r\n") << victim << " cut to " << length;
    } catch (const Error& error) {
      expectOneLine(error);
    }
  }
  files.write(victim, bytes);
  EXPECT_TRUE(readWhole(*openSource(open, options)) == volume.voxels) << victim << " in full";
}

void expectBitFlipsAreHarmless(const ForeignFiles& files, const std::string& victim, std::string_view bytes,
                               std::size_t header_bytes, const fs::path& open, std::uint64_t seed,
                               const SourceOptions& options, int cases) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  for (int i = 0; i < cases; ++i) {
    std::string damaged(bytes);
    for (std::uint64_t flips = 1 + random() % 3; flips > 0; --flips) {
      damaged[random() % header_bytes] ^= static_cast<char>(1u << (random() % 8));
    }
    files.write(victim, damaged);
    try {
      const std::unique_ptr<VolumeSource> source = openSource(open, options);
      const Extent3 dims = source->info().geometry.dims;
      // Reads only volumes of a test's size; the reader itself allocates only the requested box.
      if (dims.x < 2000 && dims.y < 2000 && dims.z < 2000 && dims.count() < 1'000'000) readWhole(*source);
    } catch (const Error& error) {
      expectOneLine(error);
    }
  }
  files.write(victim, bytes);
}

fs::path realData(const std::string& name) {
#ifdef KILN_TEST_DATA_DIR
  const fs::path path = fs::path(KILN_TEST_DATA_DIR) / name;
  std::error_code ignored;
  if (fs::exists(path, ignored)) return path;
#endif
  static_cast<void>(name);
  return {};
}

}  // namespace kiln::test
