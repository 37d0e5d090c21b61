#include "render/frame_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "base/error.h"
#include "base/memory.h"
#include "base/parallel.h"
#include "base/trace.h"
#include "frame/brick_walk.h"
#include "frame/make_visibility.h"
#include "frame/volume_mix.h"
#include "render/aov_planes.h"
#include "render/frame_drawing.h"
#include "render/panorama.h"
#include "render/pixel_filter.h"
#include "splat/coverage.h"
#include "splat/projected_values.h"
#include "splat/tile_planes.h"

namespace kiln {
namespace {

// RGBA in floats, and what goes with it.
std::uint64_t pixelBytes(const RenderJob& job) {
  const bool projects = job.picture.mode != Mode::kComposite;
  return 16 + aovBytes(job.picture.aovs) + (projects ? ProjectedValues::bytesOfPixel(job.picture.mode) : 0);
}

// Pictures in memory at a time: of both eyes, and as many again while one is put beside the other.
std::uint64_t picturesHeld(const RenderJob& job) {
  if (!drawsBothEyes(job.picture.stereo)) return 1;
  const auto beside = [](const std::filesystem::path& path) {
    return !path.empty() && path.extension() != ".exr" && !hasEyePlace(path);
  };
  const std::vector<OutputFile>& files = job.output.files;
  const bool any = beside(job.output.path) || beside(job.output.video.path) ||
                   std::any_of(files.begin(), files.end(), [&](const OutputFile& file) { return beside(file.path); });
  return any ? 4 : 2;
}

bool drawsSlabs(const RenderJob& job) {
  return job.picture.mode == Mode::kComposite && job.picture.lattice == Lattice::kPixel;
}

bool castsRays(const RenderJob& job) {
  return job.picture.mode == Mode::kComposite && job.picture.lattice == Lattice::kRay;
}

// Where it is drawn, also what slabs cover of it; a partial image's file has that, too.
std::uint64_t drawnPixelBytes(const RenderJob& job) {
  const std::size_t coverage = sizeof(CoveredPixel) + (drawsPart(job.picture) ? sizeof(float) : 0);
  return pixelBytes(job) + (drawsSlabs(job) ? coverage : 0);
}

// The octree above bricks has some 12 bytes a brick and a seventh.
constexpr std::uint64_t kWalkBytes = 16;
// Of several volumes, a brick is in the lists of two or three zones, and in two sets of those drawn.
constexpr std::uint64_t kMixBytes = 4 * sizeof(VolumeMix::Brick) + 2 * 64;

// What a square being swept takes for each pixel of it and of a margin around it: samples that wait for their slabs,
// two sheets and what the pixels own. A unit of 16 x 8 x 8 samples, half a pixel apart, is 10 pixels deep at most and
// half of their samples wait at a time: 8 a cubic pixel of 32 bytes make 1.2 KiB. Measured over flames and bone in skin
// of three volumes at 0.3 to 2 pixels a voxel: 1.7 KiB at the most.
constexpr std::uint64_t kSweepBytesOfPixel = 1800;
// The same where samples are nearer than by default: 2.3 KiB at the most, at a quarter of a voxel.
constexpr std::uint64_t kSweepBytesOfNearPixel = 2800;
constexpr std::uint64_t kSweepMargin = 4;
// A unit's voxels and samples.
constexpr std::uint64_t kUnitBytes = 512u << 10;

// In smaller squares, units that touch several are refined too often. unit: pixels.
constexpr int kLeastSweep = 16;

std::uint64_t slabBytes(const RenderJob& job, int edge, int bricks_together, std::int64_t brick_size) {
  const std::uint64_t padded = static_cast<std::uint64_t>(edge) + 2 * kSweepMargin;
  const std::uint64_t threads = job.speed.tile_px == 0 ? 1 : ThreadLimit::active();
  const bool near = job.picture.sample_distance < kSampleDistance;
  // As many samples and sheets again are of what is told beside colours.
  const std::uint64_t of_pixel =
      (near ? kSweepBytesOfNearPixel : kSweepBytesOfPixel) * (job.picture.aovs.any() ? 2 : 1);
  const std::uint64_t together = threads > 1 ? static_cast<std::uint64_t>(bricks_together) : 1;
  const std::uint64_t volumes = std::max<std::uint64_t>(job.volumes.size(), 1);
  // Rays need no sheets and nothing that waits.
  const std::uint64_t swept = drawsSlabs(job) ? padded * padded * volumes * of_pixel : 0;
  return threads * (swept + kUnitBytes) + together * PixelLattice::cellBytes(brick_size);
}

bool splatsVoxels(const RenderJob& job) {
  return job.picture.mode == Mode::kComposite && job.picture.lattice == Lattice::kVoxel;
}

// What each thread holds a tile's pixels in while it splats voxels into them. `drawn`: at a time. unit: sub-pixels.
std::uint64_t planesBytes(const RenderJob& job, const ImageSize& drawn) {
  const auto width = static_cast<std::size_t>(drawn.width), height = static_cast<std::size_t>(drawn.height);
  const auto tile = static_cast<std::size_t>(job.speed.tile_px);
  if (tile == 0) return TilePlanes::bytesFor(width, height);
  return ThreadLimit::active() * TilePlanes::bytesFor(std::min(tile, width), std::min(tile, height));
}

// A piece of the picture is drawn as a whole, as the picture is.
constexpr int kNoBands = 1 << 24;

PixelFilter filterOf(const RenderJob& job) {
  const bool panorama = job.picture.camera.projection == Projection::kEquirectangular;
  return PixelFilter(job.picture.samples.value_or(1), castsRays(job) && !panorama);
}

// unit: sub-pixels.
ImageSize bandSize(const PixelRect& drawn, const PixelFilter& filter, int rows) {
  const int edge = filter.edge(), beside = 2 * filter.reach();
  return {edge * drawn.width() + beside, std::min(rows, edge * drawn.height()) + beside};
}

std::uint64_t bandBytes(const RenderJob& job, const ImageSize& band) {
  return static_cast<std::uint64_t>(band.width) * static_cast<std::uint64_t>(band.height) * drawnPixelBytes(job);
}

// What visibility is known of, at the most, where a crop is drawn: it begins where a tile does. unit: sub-pixels.
ImageSize testedSize(const RenderJob& job, const PixelRect& drawn, const PixelFilter& filter) {
  const int edge = filter.edge(), beside = 2 * filter.reach() + std::max(job.speed.tile_px, kVisibilityTile);
  const ImageSize& size = job.picture.size;
  return {std::min(edge * size.width, edge * drawn.width() + beside),
          std::min(edge * size.height, edge * drawn.height() + beside)};
}

// What may go to something that is better the larger it is, where so much is taken: no more than bricks get.
std::uint64_t shareOf(std::uint64_t budget, std::uint64_t taken) {
  return taken < budget ? std::min(budget / 4, (budget - taken) / 2) : 0;
}

}  // namespace

FrameMemory frameMemory(const StoreReader& store, const RenderJob& job) {
  return frameMemory({&store}, job, store.largestReadBytes());
}

FrameMemory frameMemory(const std::vector<const StoreReader*>& stores, const RenderJob& job,
                        std::uint64_t brick_bytes) {
  const PixelFilter filter = filterOf(job);
  const int edge = filter.edge();
  const ImageSize& size = job.picture.size;
  FrameMemory out;
  const PixelRect drawn = drawnPixels(size, job.picture.crop);
  const std::uint64_t pixels = drawn.count();
  const bool banded = !filter.inPlace(drawn, size);
  out.image = pixels * (banded ? pixelBytes(job) : drawnPixelBytes(job)) * picturesHeld(job);
  if (drawsDeep(job)) out.deep = DeepSamples::bytesFor(pixels, job.output.deep_bound) * eyesOf(job.picture).size();
  const bool edges = drawsPart(job.picture) && drawsSlabs(job);
  if (edges) out.edges = out.least_edges = EdgeLayers::bytesFor(pixels, out.edge_pixel_bytes);
  ImageSize tested = testedSize(job, drawn, filter);
  if (job.picture.camera.projection == Projection::kEquirectangular) {
    View panorama;
    panorama.focal_px = size.height / std::numbers::pi;
    tested = panoramaFaces(panorama).front().size;
    out.face =
        static_cast<std::uint64_t>(tested.width) * static_cast<std::uint64_t>(tested.height) * drawnPixelBytes(job) +
        pixels * sizeof(float);
  }
  const bool composites = job.picture.mode == Mode::kComposite;
  if (composites) out.visibility = visibilityBytes(job.speed.visibility.method, tested);
  const std::uint64_t of_brick = job.volumes.empty() ? kWalkBytes + sizeof(BrickInView) : kMixBytes;
  for (const StoreReader* const store : stores) out.index += store->index().bytes() + store->index().size() * of_brick;
  out.brick = brick_bytes;
  out.several = !job.volumes.empty();
  out.trace = job.trace.empty() ? 0 : Trace::kMemoryBytes;
  if (!filter.none() && !banded) {
    out.image += PixelFilter::copiedBytes(size);
    out.band_px = kNoBands;
  }
  if (banded) out.band = out.least_band = bandBytes(job, bandSize(drawn, filter, out.band_px));
  if (drawsSlabs(job) || castsRays(job)) {
    const std::uint64_t budget = job.speed.memory_bytes;
    const auto fits = [&] { return out.slabs <= budget / 8 && out.besideBricks() + out.brick <= budget; };
    std::int64_t brick_size = 0;
    for (const StoreReader* const store : stores) brick_size = std::max(brick_size, store->manifest().brick_size);
    out.least_slabs = slabBytes(job, kLeastSweep, 1, brick_size);
    const auto sized = [&] { return slabBytes(job, out.sweep_px, out.bricks_together, brick_size); };
    out.slabs = sized();
    while (out.bricks_together > kEnoughBricksTogether && !fits()) out.bricks_together /= 2, out.slabs = sized();
    while (drawsSlabs(job) && out.sweep_px > kLeastSweep && !fits()) out.sweep_px /= 2, out.slabs = sized();
    if (!fits()) out.bricks_together = 1, out.slabs = sized();
  }
  if (splatsVoxels(job)) {
    const bool faces = job.picture.camera.projection == Projection::kEquirectangular;
    const ImageSize at_a_time = banded  ? bandSize(drawn, filter, out.band_px)
                                : faces ? tested
                                        : ImageSize{drawn.width(), drawn.height()};
    out.slabs = out.least_slabs = planesBytes(job, at_a_time);
  }
  if (edges) {
    const std::uint64_t share = shareOf(job.speed.memory_bytes, out.besideBricks() + out.brick);
    out.edge_pixel_bytes = std::clamp(share / pixels, EdgeLayers::kLeastPixelBytes, EdgeLayers::kMostPixelBytes);
    out.edges = EdgeLayers::bytesFor(pixels, out.edge_pixel_bytes);
  }
  if (banded) {
    const std::uint64_t planes = splatsVoxels(job) ? out.slabs : 0;
    const std::uint64_t share = shareOf(job.speed.memory_bytes, out.besideBricks() - out.band - planes + out.brick);
    const auto charge = [&](int rows) {
      const ImageSize band = bandSize(drawn, filter, rows);
      out.band = bandBytes(job, band);
      if (splatsVoxels(job)) out.slabs = planesBytes(job, band);
      return out.band + (splatsVoxels(job) ? out.slabs : 0);
    };
    while (out.band_px < edge * drawn.height() && charge(2 * out.band_px) <= share) out.band_px *= 2;
    charge(out.band_px);
  }
  // Those that are drawn stay in memory; half of it is for what is read meanwhile.
  const std::uint64_t rest = job.speed.memory_bytes - std::min(job.speed.memory_bytes, out.besideBricks());
  const std::uint64_t held = std::clamp<std::uint64_t>(rest / 2 / std::max<std::uint64_t>(out.brick, 1),
                                                       kEnoughBricksTogether, kMostBricksTogether);
  out.bricks_together = std::min(out.bricks_together, static_cast<int>(held));
  return out;
}

std::uint64_t writeBehindBytes(const FrameMemory& memory, const RenderJob& job) {
  // What these hold beside their pictures is large.
  if (drawsDeep(job) || drawsPart(job.picture)) return 0;
  const std::uint64_t pixels = drawnPixels(job.picture.size, job.picture.crop).count();
  const std::uint64_t bytes = 2 * pixels * pixelBytes(job) * picturesHeld(job);
  return memory.besideBricks() + memory.brick + 4 * bytes <= job.speed.memory_bytes ? bytes : 0;
}

std::uint64_t cacheBytes(const FrameMemory& memory, std::uint64_t budget_bytes, const std::filesystem::path& store) {
  if (memory.smallest() > budget_bytes) {
    const auto part = [](std::uint64_t bytes, const char* of) {
      return bytes > 0 ? fmt::format("{} of {}, ", formatBytes(bytes), of) : std::string();
    };
    throw Error(ErrorCode::kBudget, store, "--memory",
                fmt::format("{} is too little: {} is the smallest that works here ({} of image, {}{} of visibility, {} "
                            "of index, {} to draw with, {}{} {})",
                            formatBytes(budget_bytes), roundedUpBytes(memory.smallest()),
                            formatBytes(memory.image + memory.face),
                            part(memory.least_band, "a band of samples (--samples, --crop of rays)") +
                                part(memory.deep, "deep samples (--deep-samples)") +
                                part(memory.least_edges, "a part's edges (--part)"),
                            formatBytes(memory.visibility), formatBytes(memory.index), formatBytes(memory.least_slabs),
                            part(memory.trace, "the trace"), formatBytes(memory.brick), memory.brickText()));
  }
  return budget_bytes - memory.besideBricks();
}

}  // namespace kiln
