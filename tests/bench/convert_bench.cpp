// Conversion of a volume in memory to bricks on disk: `kiln convert`, with aprons, octrees, checksums and coarser
// levels. The baseline is a simple OpenVDB program that fills 128³ grids from a dense array and writes them, a brick a
// thread, with equal compression. Both end when all data are on the disk.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Dense.h>

#include <filesystem>

#include "base/file/file.h"
#include "base/thread/parallel.h"
#include "convert/convert.h"
#include "ingest/open_source.h"
#include "store/manifest/manifest.h"
#include "support/volumes/procedural.h"

namespace kiln {
namespace {
namespace fs = std::filesystem;

// The source is in memory, so that only the conversion is timed.
VolumeSource& head() {
  static const test::DenseVolume volume = [] {
    const auto phantom = openSource("phantom:head:512x512x512", {});
    test::DenseVolume out{phantom->info().geometry, phantom->info().type, {}};
    const VoxelBox all = boxOf(out.geometry.dims);
    out.voxels.resize(static_cast<std::size_t>(all.count()) * sizeOf(out.type));
    phantom->read(all, out.voxels);
    return out;
  }();
  static test::DenseSource source(volume);
  return source;
}

fs::path freshDirectory() {
  const fs::path out = fs::temp_directory_path() / "kiln_convert_bench";
  fs::remove_all(out);
  fs::create_directories(out);
  return out;
}

void count(benchmark::State& state, const fs::path& written) {
  std::uint64_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(written))
    bytes += entry.is_regular_file() ? entry.file_size() : 0;
  fs::remove_all(written);
  state.SetItemsProcessed(state.iterations() * head().info().geometry.dims.count());  // voxels
  state.counters["MiB on disk"] = static_cast<double>(bytes) / (1 << 20);
}

// Argument: threads.
void kilnConvert(benchmark::State& state) {
  const ThreadLimit threads(static_cast<unsigned>(state.range(0)));
  head();
  fs::path out;
  for (auto _ : state) {
    state.PauseTiming();
    out = freshDirectory();
    state.ResumeTiming();
    Progress silent;
    convert(head(), out / "head.kiln", {}, silent);
  }
  count(state, out);
}

// Argument: threads.
void plainOpenVdbWriter(benchmark::State& state) {
  const ThreadLimit threads(static_cast<unsigned>(state.range(0)));
  openvdb::initialize();
  const SourceInfo& info = head().info();
  const Extent3 lattice = brickLattice(info.geometry.dims, kDefaultBrickSize);
  fs::path out;
  for (auto _ : state) {
    state.PauseTiming();
    out = freshDirectory();
    state.ResumeTiming();
    parallelFor(static_cast<std::size_t>(lattice.count()), [&](std::size_t i) {
      const VoxelBox box =
          coreBox(brickAt(lattice, static_cast<std::int64_t>(i)), kDefaultBrickSize, info.geometry.dims);
      std::vector<std::byte> voxels(static_cast<std::size_t>(box.count()) * sizeOf(info.type));
      head().read(box, voxels);
      const openvdb::CoordBBox where(
          {static_cast<int>(box.lo.x), static_cast<int>(box.lo.y), static_cast<int>(box.lo.z)},
          {static_cast<int>(box.hi.x - 1), static_cast<int>(box.hi.y - 1), static_cast<int>(box.hi.z - 1)});
      const auto grid = openvdb::Int32Grid::create();
      withVoxelType(info.type, [&]<class T>(std::type_identity<T>) {
        const openvdb::tools::Dense<T, openvdb::tools::LayoutXYZ> dense(where, reinterpret_cast<T*>(voxels.data()));
        openvdb::tools::copyFromDense(dense, *grid, 0, /*serial=*/true);
      });
      openvdb::io::File file((out / fmt::format("{}.vdb", i)).string());
      file.setCompression(openvdb::io::COMPRESS_BLOSC | openvdb::io::COMPRESS_ACTIVE_MASK);
      file.write({grid});
    });
    FileSystem::real().syncAll(out);
  }
  count(state, out);
}

BENCHMARK(kilnConvert)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(plainOpenVdbWriter)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace kiln

BENCHMARK_MAIN();
