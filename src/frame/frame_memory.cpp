#include "frame/frame_memory.h"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "base/error.h"
#include "base/file/file.h"
#include "base/memory/large_pages.h"
#include "base/memory/memory.h"
#include "base/thread/parallel.h"
#include "base/thread/trace.h"
#include "frame/background.h"
#include "frame/light/light_plan.h"
#include "frame/panorama.h"
#include "frame/part_image.h"
#include "frame/pass/aov_planes.h"
#include "frame/pass/make_pass.h"
#include "frame/pass/make_visibility.h"
#include "frame/pixel_filter.h"
#include "image/file/exr_cost.h"
#include "image/file/image_file.h"
#include "job/job_facts.h"
#include "job/stereo.h"

namespace kiln {
namespace {

EngineMemory largestOf(const EngineMemory& a, const EngineMemory& b) {
  EngineMemory out = a;
  for (const auto member : {&EngineMemory::thread, &EngineMemory::tile, &EngineMemory::brick, &EngineMemory::pixel,
                            &EngineMemory::stored_brick})
    out.*member = std::max(a.*member, b.*member);
  return out;
}

// `tile`: the size of the largest tile. Shadow maps are drawn by the default engine, the lattice of ambient occlusion
// by the default engine of several volumes.
EngineMemory engineMemory(const RenderJob& job, const ImageSize& tile, std::int64_t brick_size) {
  const EngineChoice engine = engineOf(job);
  const bool shadows = castsShadows(shadingOf(job));
  EngineMemory out = passMemory(engine, job.picture.aovs.any() || drawsDeep(job) || shadows, tile, brick_size);
  if (!engine.capabilities().composites) return out;
  EngineChoice of_light;
  of_light.several_volumes = engine.several_volumes;
  if (shadows) out = largestOf(out, passMemory(of_light, true, tile, brick_size));
  of_light.several_volumes = true;
  if (job.picture.shading.occlusion.strength > 0) out = largestOf(out, passMemory(of_light, false, tile, brick_size));
  return out;
}

// RGBA in floats, planes, and the engine's own numbers.
std::uint64_t pixelBytes(const RenderJob& job) {
  return 16 + aovBytes(job.picture.aovs) + engineMemory(job, {}, 0).pixel;
}

// Number of pictures in memory: two eyes, and two more while a flat file puts both eyes side by side. The mean of a
// lens's pictures is one more.
std::uint64_t picturesHeld(const RenderJob& job) {
  const std::uint64_t mean = job.picture.lens.aperture > 0 ? 1 : 0;
  if (!drawsBothEyes(job.picture.stereo)) return 1 + mean;
  const auto beside = [](const std::filesystem::path& path) {
    return extensionOf(path) != ".exr" && !hasEyePlace(path);
  };
  const std::vector<std::filesystem::path> names = namesOf(job.output);
  return (std::any_of(names.begin(), names.end(), beside) ? 4 : 2) + mean;
}

// Stacks of threads, and memory that the allocator and TBB keep per thread. Measured: the first threads decode and need
// most.
std::uint64_t threadsBytes() {
  constexpr std::uint64_t kFirst = 16, kFirstBytes = 384 << 10, kOtherBytes = 128 << 10;
  const std::uint64_t threads = ThreadLimit::active();
  return std::min(threads, kFirst) * kFirstBytes + (threads - std::min(threads, kFirst)) * kOtherBytes;
}
// Returns the number of drawing threads: one if the frame is one tile.
std::uint64_t drawingThreads(const RenderJob& job) { return job.speed.tile_px == 0 ? 1 : ThreadLimit::active(); }

// The largest tile of what is drawn at a time. unit: sub-pixels.
ImageSize largestTile(const RenderJob& job, const ImageSize& drawn) {
  const int tile = job.speed.tile_px;
  return tile == 0 ? drawn : ImageSize{std::min(tile, drawn.width), std::min(tile, drawn.height)};
}

// Letters and lines of annotations in a picture of 4K. unit: bytes.
constexpr std::uint64_t kOutlinesBytes = 8 << 20;

// A JPEG in a buffer that doubles, and its copy: noise at quality 100 takes 3.9 bytes a pixel. unit: bytes a pixel.
constexpr std::uint64_t kJpegPixelBytes = 12;

// A piece of the picture is drawn as a whole, as the picture is.
constexpr int kNoBands = 1 << 24;

PixelFilter filterOf(const RenderJob& job) {
  const bool panorama = projectionOf(job) == Projection::kEquirectangular;
  return pixelFilterOf(engineOf(job), job.picture.samples.value_or(1),
                       !panorama && !drawsPart(job.picture) && !drawsDeep(job));
}

// A partial image is a picture of its samples: each sample is a pixel.
RenderJob ofDrawnPixels(RenderJob job) {
  if (!drawsPart(job.picture)) return job;
  const SampleWindow window = sampleWindowOf(job.picture);
  job.picture.size = window.picture;
  job.picture.crop = window.samples;
  job.picture.samples = 1;
  return job;
}

std::uint64_t bandBytes(const RenderJob& job, const ImageSize& band) {
  return static_cast<std::uint64_t>(band.width) * static_cast<std::uint64_t>(band.height) * pixelBytes(job);
}

// Returns the largest rectangle of the occlusion structure for a crop, which starts at a tile's border. unit:
// sub-pixels.
ImageSize testedSize(const RenderJob& job, const PixelRect& drawn, const PixelFilter& filter) {
  const int edge = filter.edge(), beside = 2 * filter.reach() + std::max(job.speed.tile_px, kVisibilityTile);
  const ImageSize& size = job.picture.size;
  return {std::min(edge * size.width, edge * drawn.width() + beside),
          std::min(edge * size.height, edge * drawn.height() + beside)};
}

// Returns the memory that an optional buffer may take beside `taken`: at most as much as bricks get.
std::uint64_t shareOf(std::uint64_t budget, std::uint64_t taken) {
  return taken < budget ? std::min(budget / 4, (budget - taken) / 2) : 0;
}

// Charges the parts of a frame in turn. Optional parts, which share the rest, come after the necessary parts.
class FrameAccount {
 public:
  FrameAccount(const std::vector<const BrickedVolume*>& stores, const RenderJob& job, std::uint64_t brick_bytes,
               const std::optional<PixelRect>& written)
      : stores_(stores),
        job_(ofDrawnPixels(job)),
        size_(job_.picture.size),
        drawn_(drawnPixels(size_, job_.picture.crop)),
        filter_(filterOf(job_)),
        pixels_(drawn_.count()),
        panorama_(projectionOf(job_) == Projection::kEquirectangular),
        banded_(!filter_.inPlace(drawn_, size_)),
        written_(written.value_or(drawn_)),
        tested_(testedSize(job_, drawn_, filter_)) {
    out_.brick = brick_bytes;
    for (const BrickedVolume* const store : stores_) brick_size_ = std::max(brick_size_, store->manifest().brick_size);
    out_.several = !job.volumes.empty();
    out_.trace = job.trace.empty() ? 0 : Trace::kMemoryBytes;
  }

  FrameMemory charged() {
    chargePixels();
    chargeFace();
    if (engineOf(job_).capabilities().composites) chargeShadows();
    if (engineOf(job_).capabilities().composites)
      out_.visibility = visibilityBytes(job_.speed.visibility.method, tested_);
    chargeIndex();
    out_.threads = threadsBytes();
    chargeFiles(0);
    out_.least_files = out_.files;
    chargeEngine();
    if (banded_) shareWithBand();
    chargeFiles(shareOf(job_.speed.memory_bytes, out_.besideBricks() - out_.files + out_.brick));
    chooseBricksTogether();
    return out_;
  }

 private:
  void chargePixels() {
    out_.image = pixels_ * pixelBytes(job_) * picturesHeld(job_);
    const std::vector<std::filesystem::path> names = namesOf(job_.output);
    if (job_.picture.annotations.any() && std::any_of(names.begin(), names.end(), isExrPath))
      out_.image += pixels_ * kAnnotationPixelBytes * eyesOf(job_.picture).size();
    if (drawsDeep(job_))
      out_.deep = DeepSamples::bytesFor(pixels_, job_.output.deep_bound) * eyesOf(job_.picture).size();
    if (!filter_.none() && !banded_) {
      out_.image += PixelFilter::copiedBytes(size_);
      out_.band_px = kNoBands;
    }
    if (banded_) out_.band = out_.least_band = bandBytes(job_, bandSize(drawn_, filter_, out_.band_px));
  }

  void chargeFace() {
    if (!panorama_) return;
    View view;
    view.focal_px = size_.height / std::numbers::pi;
    tested_ = panoramaFaces(view).front().size;
    out_.face =
        static_cast<std::uint64_t>(tested_.width) * static_cast<std::uint64_t>(tested_.height) * pixelBytes(job_) +
        pixels_ * sizeof(float);
  }

  void chargeShadows() {
    std::vector<Clipping> clippings;
    for (const VolumeOptions& volume : job_.volumes) clippings.push_back(volume.clipping);
    if (clippings.empty()) clippings.push_back(job_.picture.clipping);
    out_.shadows = illuminationBytes(stores_, clippings, shadingOf(job_), !job_.animation.lights.empty(), size_);
  }

  void chargeIndex() {
    const std::uint64_t of_brick = engineMemory(job_, {}, brick_size_).stored_brick;
    for (const BrickedVolume* const store : stores_)
      out_.index += store->heldBytes() + store->index().size() * of_brick;
  }

  // Charges the largest file, as files are written in turn. A file may hold both eyes.
  void chargeFiles(std::uint64_t share) {
    const std::vector<std::filesystem::path> names = namesOf(job_.output);
    const bool annotated = job_.picture.annotations.any();
    out_.files = showsAsDrawn(displayOf(job_.picture)) ? 0 : picturesHeld(job_) * ShownRows::bytesFor(written_.width());
    // A JPEG is compressed in memory.
    const auto is_jpeg = [](const std::filesystem::path& path) {
      return pictureFormatOf(path) == PictureFormat::kJpeg;
    };
    if (std::any_of(names.begin(), names.end(), is_jpeg)) out_.files += kJpegPixelBytes * written_.count();
    if (annotated) out_.files += ShownRows::bytesFor(written_.width()) + kOutlinesBytes;
    if (std::none_of(names.begin(), names.end(), isExrPath)) return;
    const std::uint64_t eyes = eyesOf(job_.picture).size();
    const auto bytesOf = [&](const ExrShape& shape) {
      return eyes * exrBytes(shape, exrWorkWithin(shape, share / eyes));
    };
    const ExrShape flat{written_.width(), written_.height(), job_.output.exr_float || drawsPart(job_.picture),
                        aovBytes(job_.picture.aovs) + (annotated ? kAnnotationPixelBytes : 0),
                        job_.output.exr_compression};
    out_.files = std::max(out_.files, bytesOf(flat));
    if (!drawsDeep(job_)) return;
    constexpr std::uint64_t kDepths = 2 * sizeof(float);
    const ExrShape deep{written_.width() * std::int64_t{job_.output.deep_bound.samples}, written_.height(),
                        job_.output.exr_float, kDepths, "zips"};
    out_.files = std::max(out_.files, exrBytes(deep, exrWork(deep, 0)));
  }

  // The engine's memory with so many bricks, and so many sub-pixels, at a time.
  EngineMemory engineAt(const ImageSize& drawn) const {
    return engineMemory(job_, largestTile(job_, drawn), brick_size_);
  }
  std::uint64_t engineBytes(int bricks_together, const ImageSize& drawn) const {
    const EngineMemory engine = engineAt(drawn);
    const std::uint64_t threads = drawingThreads(job_);
    const std::uint64_t together = threads > 1 ? static_cast<std::uint64_t>(bricks_together) : 1;
    return threads * (engine.thread + engine.tile) + together * engine.brick;
  }

  // The most bricks at a time whose memory is little of the budget.
  void chargeEngine() {
    const std::uint64_t budget = job_.speed.memory_bytes;
    const ImageSize drawn = banded_     ? bandSize(drawn_, filter_, out_.band_px)
                            : panorama_ ? tested_
                                        : ImageSize{drawn_.width(), drawn_.height()};
    const auto fits = [&] { return out_.slabs <= budget / 8 && out_.besideBricks() + out_.brick <= budget; };
    out_.least_slabs = engineBytes(1, drawn);
    const auto charge = [&] { out_.slabs = engineBytes(out_.bricks_together, drawn); };
    charge();
    if (engineAt(drawn).brick == 0) return;
    while (out_.bricks_together > kEnoughBricksTogether && !fits()) out_.bricks_together /= 2, charge();
    if (!fits()) out_.bricks_together = 1, charge();
  }

  // A higher band takes memory for its pixels, and for the tiles of the threads.
  void shareWithBand() {
    const auto tiles = [&](const ImageSize& drawn) { return drawingThreads(job_) * engineAt(drawn).tile; };
    const std::uint64_t first_tiles = tiles(bandSize(drawn_, filter_, out_.band_px));
    const std::uint64_t share =
        shareOf(job_.speed.memory_bytes, out_.besideBricks() - out_.band - first_tiles + out_.brick);
    const std::uint64_t engine = out_.slabs - first_tiles;
    const auto charge = [&](int rows) {
      const ImageSize band = bandSize(drawn_, filter_, rows);
      out_.band = bandBytes(job_, band);
      out_.slabs = engine + tiles(band);
      return out_.band + tiles(band);
    };
    while (out_.band_px < filter_.edge() * drawn_.height() && charge(2 * out_.band_px) <= share) out_.band_px *= 2;
    charge(out_.band_px);
  }

  // Drawn bricks stay in memory; half of the memory is for bricks read meanwhile.
  void chooseBricksTogether() {
    const std::uint64_t rest = job_.speed.memory_bytes - std::min(job_.speed.memory_bytes, out_.besideBricks());
    const std::uint64_t held = std::clamp<std::uint64_t>(rest / 2 / std::max<std::uint64_t>(out_.brick, 1),
                                                         kEnoughBricksTogether, kMostBricksTogether);
    out_.bricks_together = std::min(out_.bricks_together, static_cast<int>(held));
  }

  const std::vector<const BrickedVolume*>& stores_;
  const RenderJob job_;
  const ImageSize& size_;
  const PixelRect drawn_;
  const PixelFilter filter_;
  const std::uint64_t pixels_;
  const bool panorama_, banded_;
  const PixelRect written_;
  ImageSize tested_;             // rectangle of the occlusion structure
  std::int64_t brick_size_ = 0;  // the largest of the stores
  FrameMemory out_;
};

}  // namespace

FrameMemory frameMemory(const BrickedVolume& store, const RenderJob& job) {
  return frameMemory({&store}, job, store.largestReadBytes());
}

FrameMemory frameMemory(const std::vector<const BrickedVolume*>& stores, const RenderJob& job,
                        std::uint64_t brick_bytes, const std::optional<PixelRect>& written) {
  return FrameAccount(stores, job, brick_bytes, written).charged();
}

std::uint64_t writeBehindBytes(const FrameMemory& memory, const RenderJob& job) {
  // These kinds of pictures hold much memory beside their pixels.
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
                                part(memory.shadows, "shadows and ambient occlusion (--shadows, --ambient-occlusion)"),
                            formatBytes(memory.visibility), formatBytes(memory.index), formatBytes(memory.least_slabs),
                            part(memory.least_files, "a file's compression (--compression)") +
                                part(memory.threads, "threads' stacks (--threads)") + part(memory.trace, "the trace") +
                                part(memory.functions, "transfer functions"),
                            formatBytes(memory.brick), memory.brickText()));
  }
  return budget_bytes - memory.besideBricks() - sparePagesBytes(memory, budget_bytes);
}

std::uint64_t sparePagesBytes(const FrameMemory& memory, std::uint64_t budget_bytes) {
  const std::uint64_t needed_bytes = memory.besideBricks() + memory.brick;
  if (memory.brick < kLargePage || budget_bytes <= needed_bytes) return 0;
  // An eighth costs few bricks and keeps the pages of one or two.
  return std::min({std::uint64_t{kMostSpare}, budget_bytes / 8, budget_bytes - needed_bytes});
}

}  // namespace kiln
