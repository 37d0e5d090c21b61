// Rates of every kernel, on each instruction set of the machine, and of the plain loops where they exist. Bytes and
// floating-point operations are counted from the code. Data: a brick of a head of 128³ voxels at 1.5 pixels a voxel, as
// in a picture. Visibility has a separate benchmark (occlusion_bench).
#include <benchmark/benchmark.h>
#include <hwy/targets.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "convert/convert.h"
#include "engine/pixel/pixel_engine.h"
#include "engine/pixel/ray_caster.h"
#include "engine/pixel/voxels/load_patch.h"
#include "engine/voxel/gather_voxels.h"
#include "engine/voxel/tile_walk.h"
#include "engine/voxel/voxel_engine.h"
#include "frame/pass/frame_request.h"
#include "frame/pass/make_visibility.h"
#include "ingest/open_source.h"
#include "scene/camera/framing.h"
#include "scene/transfer/presets.h"
#include "store/store_reader.h"
#include "support/reference/scalar_kernels.h"
#include "support/reference/scalar_voxels.h"

namespace kiln {
namespace {
namespace fs = std::filesystem;

constexpr int kPicture = 256;
constexpr std::size_t kPatchFloats =
    std::size_t{kPatchVoxels + 2 * kPatchMargin} * (kPatchVoxels + 2 * kPatchMargin) * kPatchStride;

fs::path madeStore() {
  const fs::path out = fs::temp_directory_path() / "kiln_kernel_bench.kiln";
  ConvertOptions options;
  options.overwrite = true;
  Progress silent;
  const auto source = openSource("phantom:head:128x128x128", {});
  convert(*source, out, options, silent);
  return out;
}

FrameRequest requestFor(const StoreReader& store, Interpolation interpolation) {
  FrameRequest out;
  const ImageSize size{kPicture, kPicture};
  out.view = resolve(frameVolume(store.manifest().geometry(), defaultFraming(), size), size);
  out.transfer_function = presetFor("ct-skin", store.manifest());
  out.interpolation = interpolation;
  out.level = 0;
  return out;
}

// A brick as decoded for a frame, and its visible patches.
struct Scene {
  explicit Scene(const StoreReader& store, Interpolation interpolation)
      : request(requestFor(store, interpolation)),
        levels(store.manifest(), request.level, request.view, request.visibility.area),
        appearance(store.manifest(), request.transfer_function, request.shading, request.view, interpolation),
        engine(store.manifest(), levels, request.sampling(), appearance),
        block(store.read({0, {0, 0, 0}})),
        zones(engine.cellsOf(block)),
        fullest(*std::max_element(zones.begin(), zones.end(),
                                  [](const auto& a, const auto& b) { return a.cells.size() < b.cells.size(); })),
        frame(*fullest.frame) {
    for (const SlabCell& cell : fullest.cells) patches.push_back(cell.box.lo);
  }
  static constexpr std::int64_t voxelsRead() {
    constexpr std::int64_t kEdge = kPatchVoxels + 2 * kPatchMargin;
    return kEdge * kEdge * kEdge;
  }

  FrameRequest request;
  FrameLevels levels;
  VolumeAppearance appearance;
  PixelEngine engine;
  BrickBlock block;
  std::vector<PixelEngine::ZoneCells> zones;
  const PixelEngine::ZoneCells& fullest;
  const SlabContext& frame;
  std::vector<VoxelCoord> patches;
};

const StoreReader& benchStore() {
  static const StoreReader store(madeStore());
  return store;
}

const Scene& scene(Interpolation interpolation = Interpolation::kLinear) {
  const StoreReader& store = benchStore();
  static const Scene linear(store, Interpolation::kLinear), cubic(store, Interpolation::kCubic);
  return interpolation == Interpolation::kLinear ? linear : cubic;
}

// Reports rates per second: items, and the bytes and operations of each item.
void report(benchmark::State& state, std::int64_t items, double bytes, double flops) {
  using benchmark::Counter;
  const double all = static_cast<double>(items);
  state.counters["items"] = Counter(all, Counter::kIsRate);
  state.counters["bytes"] = Counter(all * bytes, Counter::kIsRate, Counter::kIs1024);
  state.counters["flops"] = Counter(all * flops, Counter::kIsRate);
}

// Argument: the instruction set, or 0 for plain loops.
class OnTarget {
 public:
  explicit OnTarget(benchmark::State& state) : target_(state.range(0)) {
    hwy::SetSupportedTargetsForTest(target_);
    state.SetLabel(plain() ? "plain" : instructionSet());
  }
  ~OnTarget() { hwy::SetSupportedTargetsForTest(0); }
  bool plain() const { return target_ == 0; }

 private:
  const std::int64_t target_;
};

// Items are voxels: of two bytes read, four written; a subtraction and two comparisons.
void loadPatches(benchmark::State& state) {
  const OnTarget on(state);
  const Scene& s = scene();
  alignas(64) static float values[kPatchFloats];
  const double offset = s.frame.table().offset();
  std::size_t next = 0;
  for (auto _ : state) {
    const VoxelCoord& lo = s.patches[next++ % s.patches.size()];
    const SampledRange range = on.plain() ? test::loadPatchScalar(s.block, s.frame.lattice(), offset, lo, values)
                                          : loadPatch(s.block, s.frame.lattice(), offset, lo, values);
    benchmark::DoNotOptimize(range);
    benchmark::ClobberMemory();
  }
  report(state, state.iterations() * s.voxelsRead(), 6, 3);
}

// Items are the visible samples on rays, among all samples in a brick's cells. A sample reads 32 voxels, two entries of
// the table and a pixel, and writes the pixel; interpolation, gradient and light take about 210 operations.
void castBrick(benchmark::State& state) {
  const OnTarget on(state);
  const Scene& s = scene();
  constexpr PixelRect kTile{96, 96, 96 + kSquareEdge, 96 + kSquareEdge};
  std::int64_t samples = 0;
  for (auto _ : state) {
    Image image(kSquareEdge, kSquareEdge);
    const auto visibility = makeVisibility({}, s.request.view.size, 0);
    TilePixels tile;
    tile.rect = kTile, tile.rgba = image.pixel(0, 0), tile.stride = 4 * kSquareEdge;
    DrawCounts counts;
    castRays(*s.fullest.rays, s.frame, s.block, s.fullest.cells, tile, *visibility, 0.998f, counts);
    samples += static_cast<std::int64_t>(counts.splats);
  }
  report(state, samples, 4 * 32 + 32 + 2 * 16, 210);
}

// A cell's voxels, all opaque enough to be visible, at 1.5 pixels a voxel in perspective.
struct VoxelScene {
  explicit VoxelScene(const Scene& s)
      : projector(s.levels.projector(0)), view(projector, plainLight(s.request.shading, {1e-3f}, projector)) {
    const VoxelCoord lo = {60, 60, 60};
    std::int32_t codes[kVoxelBatch];
    for (std::int32_t i = 0; i < kVoxelBatch; ++i) codes[i] = voxelCode(i % 4, i / 4, 0);
    std::copy_n(codes, kVoxelBatch, this->codes);
    first = lo;
    projectVoxels(view, first, codes, kVoxelBatch, tile, projected);
    for (std::size_t i = 0; i < kVoxelBatch; ++i) {
      const float material[4] = {0.9f, 0.7f, 0.6f, 1e-3f}, slope = static_cast<float>(i + 1);
      std::copy_n(material, 4, shaded.material + 4 * i);
      shaded.slope[0][i] = slope, shaded.slope[1][i] = 20 - slope, shaded.slope[2][i] = 3 * slope;
    }
  }
  const Projector& projector;
  VoxelView view;
  VoxelCoord first;
  std::int32_t codes[kVoxelBatch];
  PixelRect tile = {0, 0, kPicture, kPicture};
  ProjectedVoxels projected;
  ShadedVoxels shaded;
};

// Items are visible voxels of a brick: seven voxels of two bytes read, eight numbers written; two comparisons and three
// differences.
void gatherVoxels(benchmark::State& state) {
  const OnTarget on(state);
  const Scene& s = scene();
  const VisitingOrder& order = s.levels.projector(0).order();
  const VoxelEngine engine(benchStore().manifest(), s.levels, s.appearance, {});
  std::int64_t voxels = 0;
  std::size_t next = 0;
  for (auto _ : state) {
    const VoxelCoord& lo = s.patches[next++ % s.patches.size()];
    const VoxelBox cell =
        intersection({lo, {lo.x + kSplatCellSize, lo.y + kSplatCellSize, lo.z + kSplatCellSize}}, s.block.core);
    FoundVoxels found;
    findVoxels(engine.classifier(), order, s.block, cell, found);
    ShadedVoxels taken;
    for (int first = 0; first < found.count; first += kVoxelBatch) {
      const std::uint32_t all = (1u << std::min(found.count - first, kVoxelBatch)) - 1;
      takeVoxels(engine.classifier(), s.block, found, first, all, true, taken);
      benchmark::DoNotOptimize(taken);
    }
    voxels += found.count;
  }
  report(state, voxels, 14 + 32, 8);
}

// Items are voxels: a code read, 13 numbers written; three products of a matrix, a quotient, and two roots.
void projectBatch(benchmark::State& state) {
  const OnTarget on(state);
  VoxelScene s(scene());
  for (auto _ : state) {
    if (on.plain())
      test::projectVoxelsScalar(s.view, s.first, s.codes, kVoxelBatch, s.tile, s.projected);
    else
      projectVoxels(s.view, s.first, s.codes, kVoxelBatch, s.tile, s.projected);
    benchmark::ClobberMemory();
  }
  report(state, state.iterations() * kVoxelBatch, 56, 70);
}

// Items are splats, of some 25 pixels, each read and written; 60 operations for light and ellipse, and a pixel takes
// two exponentials and four sums.
void layBatch(benchmark::State& state) {
  const OnTarget on(state);
  VoxelScene s(scene());
  const std::unique_ptr<Visibility> none = makeNoVisibility();
  Image image(kPicture, kPicture);
  TilePixels tile;
  tile.rect = s.tile, tile.rgba = image.pixel(0, 0), tile.stride = 4 * kPicture;
  TilePlanes planes;
  planes.reserve(tile.rect);
  planes.take(tile);
  double pixels = 0;
  for (std::size_t i = 0; i < kVoxelBatch; ++i)
    pixels += s.projected.rect(i).width() * s.projected.rect(i).height() / static_cast<double>(kVoxelBatch);
  for (auto _ : state) {
    if (on.plain())
      test::layVoxelsScalar(s.view, s.projected, s.shaded, s.projected.touching, tile, 2, *none);
    else
      rasterizeFootprints(s.view, s.projected, s.shaded, s.projected.touching, planes, 2, *none);
    benchmark::ClobberMemory();
  }
  report(state, state.iterations() * kVoxelBatch, 32 * pixels, 60 + 45 * pixels);
}

// The whole voxel lattice: a brick into a single tile. Items are splats: a voxel and its neighbours read, a footprint
// of pixels read and written.
void splatVoxels(benchmark::State& state) {
  const Scene& s = scene();
  const VisibilityOptions options{.method = static_cast<VisibilityMethod>(state.range(0))};
  const VoxelEngine engine(benchStore().manifest(), s.levels, s.appearance,
                           {options.method != VisibilityMethod::kNone, nullptr});
  TilePlanes planes;
  planes.reserve({0, 0, kPicture, kPicture});
  std::int64_t splats = 0;
  for (auto _ : state) {
    Image image(kPicture, kPicture);
    const auto visibility = makeVisibility(options, s.request.view.size, 0);
    DrawCounts counts;
    const TilePixels tile{{0, 0, kPicture, kPicture}, image.pixel(0, 0), 4 * kPicture, {}, nullptr};
    walkTile(engine.contextOf(0), s.block, {tile, *visibility, 0.998f, {}}, planes, counts, nullptr);
    splats += static_cast<std::int64_t>(counts.splats);
  }
  constexpr double kPixels = 36;
  state.SetLabel(options.method == VisibilityMethod::kNone ? "without visibility" : "mask");
  report(state, splats, 14 + 32 * kPixels, 60 + 12 * kPixels);
}

void registerAll() {
  const auto onTargets = [](const char* name, auto kernel, bool has_plain) {
    benchmark::internal::Benchmark* const out = benchmark::RegisterBenchmark(name, kernel);
    if (has_plain) out->Arg(0);
    test::onEveryInstructionSet([&](std::int64_t target) { out->Arg(target); });
    out->ArgName("set");
  };
  onTargets("load", loadPatches, true);
  onTargets("castBrick", castBrick, false);
  onTargets("voxels/gather", gatherVoxels, false);
  onTargets("voxels/project", projectBatch, true);
  onTargets("voxels/lay", layBatch, true);
  for (const VisibilityMethod method : {VisibilityMethod::kNone, VisibilityMethod::kMask})
    benchmark::RegisterBenchmark("voxel_lattice", splatVoxels)
        ->Arg(static_cast<std::int64_t>(method))
        ->Unit(benchmark::kMillisecond);
}

}  // namespace
}  // namespace kiln

int main(int argc, char** argv) {
  kiln::registerAll();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
