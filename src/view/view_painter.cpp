#include "view/view_painter.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/elapsed.h"
#include "base/memory/spare_pages.h"
#include "engine/shown_box.h"
#include "frame/background.h"
#include "frame/light/illuminate.h"
#include "frame/pass/frame_progress.h"
#include "image/file/image_file.h"
#include "image/file/jpeg_file.h"
#include "job/job_facts.h"
#include "job/stated_job.h"
#include "sequence/frame_annotations.h"
#include "sequence/frame_files.h"
#include "store/brick_index.h"
#include "store/manifest/json_text.h"

namespace kiln {
namespace {

// Time of a preview while the camera moves. unit: seconds.
constexpr double kMovingSeconds = 0.03;
// Pixels of the first preview, whose cost is unknown; the smallest share of a picture's sides that still shows shapes.
constexpr double kFirstPixels = 256 * 256, kLeastShare = 0.25;
// Bounds of the change from preview to preview: a slow picture makes the next small, and later pictures grow again.
constexpr double kLeastChange = 0.6, kMostChange = 1.25;
// Shares of the time beyond which the smallest preview becomes coarser, and below which a preview becomes finer.
constexpr double kSlow = 1.5, kFast = 0.5;
constexpr int kMostMovingCoarser = 2;
// Most bytes of brick files that a preview reads.
constexpr std::uint64_t kLittle = std::uint64_t{16} << 20;
constexpr int kJpegQuality = 70;
// Returns the bytes of a pixel's copies beside the drawn one: its file, the file in the client's hands, samples of a
// JPEG.
std::uint64_t copiedPixelBytes(const OutputOptions& output) {
  const std::uint64_t in_file = output.png_bits == 16 ? 8 : 4;
  return 2 * in_file + 4;
}

// Returns the levels beyond the finest of the volume with the most: all coarser pictures are equal.
int mostCoarser(const OpenedVolumes& volumes) {
  std::size_t levels = 1;
  for (const BrickedVolume* const volume : volumes.all()) levels = std::max(levels, volume->manifest().levels.size());
  return static_cast<int>(levels) - 1;
}

std::uint64_t heldBytes(const OpenedVolumes& volumes) {
  std::uint64_t out = 0;
  for (const BrickedVolume* const volume : volumes.all()) out += volume->heldBytes();
  return out;
}

// All memory but the indices and spare pages is for bricks, until a picture takes its part.
std::uint64_t bricksBytes(const RenderJob& job, const OpenedVolumes& volumes) {
  std::uint64_t least = 0;
  for (const BrickedVolume* const volume : volumes.all()) least = std::max(least, volume->largestReadBytes());
  FrameMemory memory;
  memory.index = heldBytes(volumes);
  memory.brick = least;
  boundSparePages(sparePagesBytes(memory, job.speed.memory_bytes));
  return cacheBytes(memory, job.speed.memory_bytes, volumes.first().path());
}

ImageSize scaled(const ImageSize& size, double factor, bool panorama) {
  const auto side = [&](int full) { return std::clamp(static_cast<int>(std::lround(full * factor)), 1, full); };
  ImageSize out{side(size.width), side(size.height)};
  if (panorama) out.width = 2 * out.height;
  return out;
}

PixelRect scaled(const PixelRect& crop, const ImageSize& from, const ImageSize& to) {
  const double x = static_cast<double>(to.width) / from.width, y = static_cast<double>(to.height) / from.height;
  PixelRect out{static_cast<int>(crop.x0 * x), static_cast<int>(crop.y0 * y), static_cast<int>(std::ceil(crop.x1 * x)),
                static_cast<int>(std::ceil(crop.y1 * y))};
  return {out.x0, out.y0, std::min(out.x1, to.width), std::min(out.y1, to.height)};
}

// Returns the job without size, camera and frames: equal for jobs whose pixels cost alike.
std::string costOf(const ViewedJob& job) {
  RenderJob plain = job.job;
  plain.picture.camera = {};
  plain.animation.camera = {};
  plain.frames.clear();
  // A crop has another share of a picture of another size.
  if (!plain.picture.crop) plain.picture.size = {};
  return fmt::format("{} {} {}", jsonText(statedJson(plain), -1), *job.scene.picture.samples,
                     static_cast<int>(job.scene.camera.projection));
}

double pixelsOf(const ImageSize& size) { return static_cast<double>(size.width) * size.height; }

}  // namespace

ViewPainter::ViewPainter(const RenderJob& job, OpenedVolumes volumes, Progress& progress)
    : session_(job),
      volumes_(std::move(volumes)),
      bricks_bytes_(bricksBytes(job, volumes_)),
      cache_(volumes_.all(), bricks_bytes_, readersOfCache(), skipperOf(job, progress)),
      pictures_(cache_) {}

std::unique_ptr<ViewedJob> ViewPainter::prepare(const RenderJob& job, const Progress& progress) {
  auto out = std::make_unique<ViewedJob>();
  out->job = job;
  requireVolumes(out->job);
  requireViews(out->job);
  requireFont(out->job);
  requireEngineOptions(out->job.picture);
  drawnPixels(job.picture.size, job.picture.crop);
  SilentProgress silent(progress);
  SceneInputs inputs = sceneInputsOf(out->job, volumes_, fit_, silent);
  // A camera that fits the picture needs equal boxes at each move.
  const ShownBoxOf shown_box = std::exchange(inputs.shown_box, {});
  inputs.shown_box = [&](std::size_t volume, const std::vector<TransferFunction>& functions, const Clipping& clipping) {
    for (const ShownMemo& memo : shown_) {
      if (memo.volume == volume && memo.functions == functions && memo.clipping == clipping &&
          memo.clipping.section == clipping.section)
        return memo.box;
    }
    std::erase_if(shown_, [&](const ShownMemo& memo) { return memo.volume == volume; });
    const FramedBox box = shown_box(volume, functions, clipping);
    shown_.push_back({volume, functions, clipping, box});
    return box;
  };
  out->scenes = std::make_unique<SceneOfJob>(out->job, volumes_.manifests(), inputs, progress);
  out->frame = framesOf(out->job).front();
  out->scene = out->scenes->at(out->frame);
  nlohmann::ordered_json stated = statedJson(out->job);
  // With several volumes, the bricks that meet in a tile depend on the camera.
  if (job.volumes.empty()) stated.erase("camera");
  std::string text = fmt::format("{} {} {}", jsonText(stated, -1), out->scenes->mostSamples(progress),
                                 static_cast<int>(out->scene.camera.projection));
  if (text != planned_) {
    const auto pixels = static_cast<std::uint64_t>(pixelsOf(job.picture.size));
    RenderJob drawn = out->job;
    drawn.picture.aovs = drawnAovs(drawn);
    plan_ = memoryOf(drawn, volumes_.all(), *out->scenes, copiedPixelBytes(drawn.output) * pixels, progress);
    planned_ = std::move(text);
  }
  out->memory = plan_;
  return out;
}

void ViewPainter::requireDrawable(const RenderJob& job, const Progress& progress) {
  const std::unique_ptr<ViewedJob> viewed = prepare(job, progress);
  const std::vector<int> frames = framesOf(job);
  for (const int frame : frames) {
    progress.throwIfCancelled("testing frames");
    try {
      viewed->scenes->at(frame);
    } catch (const Error& error) {
      if (frames.size() == 1) throw;
      throw Error(error.code(), fmt::format("frame {}: {}", frame, error.what()));
    }
  }
}

void ViewPainter::makeRoom(const ViewedJob& job) {
  const std::uint64_t left = cacheBytes(job.memory, session_.speed.memory_bytes, volumes_.first().path());
  if (job.memory.shadows == 0) shadows_.reset();
  pictures_.resize(bricks_bytes_ - std::min(bricks_bytes_, left));
}

// Fills `scene` with the preview's.
FrameRequest ViewPainter::previewOf(const ViewedJob& job, const ImageSize& size, int coarser, FrameScene& scene) const {
  scene = job.scene;
  PictureOptions& picture = scene.picture;
  if (picture.crop) picture.crop = scaled(*picture.crop, picture.size, size);
  picture.size = size;
  picture.samples = 1;
  picture.stereo.reset();
  picture.lens = {};
  picture.lattice = EngineChoice().lattice;
  picture.interpolation = Interpolation::kLinear;
  const EngineCapabilities& engine =
      EngineChoice{picture.mode, picture.lattice, !job.job.volumes.empty()}.capabilities();
  if (engine.sample_distance) picture.sample_distance = kMostSampleDistance;
  if (engine.coarser_levels) {
    picture.coarser += coarser;
    if (picture.level) picture.coarser = coarser, picture.level.reset();
  }
  FrameRequest request = requestOf(scene, job.job.speed, job.memory);
  volumes_.dress(request);
  if (request.engine().capabilities().composites && isShaded(request.shading))
    request.illumination = knownIllumination(request, shadows_.get());
  return request;
}

int ViewPainter::coarserWithin(const ViewedJob& job, const ImageSize& size, std::uint64_t bytes,
                               const Progress& progress) const {
  const int most = mostCoarser(volumes_);
  for (int coarser = 0; coarser < most; ++coarser) {
    progress.throwIfCancelled("counting bricks");
    FrameScene scene;
    const FrameRequest request = previewOf(job, size, coarser, scene);
    BrickWalkCounts counts;
    std::uint64_t missing = 0;
    for (const StoredBrick& brick : bricksInView(volumes_.all(), request, counts)) {
      if (!cache_.holds(brick))
        missing += volumes_.all()[static_cast<std::size_t>(brick.store)]->index().at(brick.key).file_bytes;
    }
    if (missing <= bytes || !request.engine().capabilities().coarser_levels) return coarser;
  }
  return most;
}

int ViewPainter::coarserToReadLittle(const ViewedJob& job, const Progress& progress) {
  makeRoom(job);
  return coarserWithin(job, job.job.picture.size, kLittle, progress);
}

ViewPicture ViewPainter::draw(const ViewedJob& job, const ImageSize& size, int coarser, bool filtered,
                              const Progress& progress) {
  const auto begin = std::chrono::steady_clock::now();
  FrameScene scene;
  FrameRequest request = previewOf(job, size, coarser, scene);
  request.filters_rays = filtered;
  SilentProgress silent(progress);
  ViewPicture out;
  const Image image = renderFrame(cache_, request, silent, out.statistics);
  const Finish finish = finishOf(scene.picture, scene.transfer_function);
  const int first_row = drawnPixels(size, scene.picture.crop).y0;
  const std::unique_ptr<ImageRows> shown = shownRows(image, first_row, finish);
  RowsUntilStopped rows(*shown, progress);
  // A JPEG has no alpha.
  const bool opaque = isOpaque(backgroundOf(scene.picture, scene.transfer_function));
  out.bytes = opaque ? encodeJpeg(rows, kJpegQuality) : encodedPng(rows, {});
  out.type = opaque ? "image/jpeg" : "image/png";
  out.width = image.width;
  out.height = image.height;
  out.seconds = secondsSince(begin);
  return out;
}

ViewPicture ViewPainter::moving(const ViewedJob& job, const Progress& progress) {
  const auto begin = std::chrono::steady_clock::now();
  makeRoom(job);
  const ImageSize& full = job.job.picture.size;
  if (moving_pixels_ == 0) moving_pixels_ = kFirstPixels;
  const double least = kLeastShare * kLeastShare * pixelsOf(full);
  moving_pixels_ = std::clamp(moving_pixels_, least, pixelsOf(full));
  const bool smallest = moving_pixels_ <= least;
  const bool panorama = job.scene.camera.projection == Projection::kEquirectangular;
  const ImageSize size = scaled(full, std::sqrt(moving_pixels_ / pixelsOf(full)), panorama);
  ViewPicture out =
      draw(job, size, std::max(coarserWithin(job, size, kLittle, progress), moving_coarser_), false, progress);
  out.seconds = secondsSince(begin);
  // The time of reading says nothing about the next picture.
  if (out.statistics.bricks_read > 0) return out;
  moving_pixels_ *= std::clamp(kMovingSeconds / out.seconds, kLeastChange, kMostChange);
  // Work for each brick does not shrink with the picture: fewer bricks, of a coarser level, do.
  if (smallest && out.seconds > kSlow * kMovingSeconds)
    moving_coarser_ = std::min(moving_coarser_ + 1, kMostMovingCoarser);
  else if (out.seconds < kFast * kMovingSeconds)
    moving_coarser_ = std::max(moving_coarser_ - 1, 0);
  return out;
}

ViewPicture ViewPainter::refined(const ViewedJob& job, int coarser, const Progress& progress) {
  makeRoom(job);
  return draw(job, job.job.picture.size, coarser, true, progress);
}

DrawnFrame ViewPainter::exact(const ViewedJob& job, Progress& progress) {
  makeRoom(job);
  const auto request_for = [&](const FrameScene& scene) {
    FrameRequest request = requestOf(scene, job.job.speed, job.memory);
    request.aovs = drawnAovs(job.job);
    volumes_.dress(request);
    request.last_illumination = &shadows_;
    return request;
  };
  DrawnFrame out = drawFrame(cache_, job.scene, request_for, job.frame, progress);
  judge(out, request_for(out.scene), volumes_);
  if (out.statistics.bricks_read == 0) {
    exact_pixel_s_ = out.statistics.wall_s / pixelsOf(job.job.picture.size);
    exact_cost_ = costOf(job);
  }
  return out;
}

ViewPicture ViewPainter::png(const ViewedJob& job, DrawnFrame drawn, const Progress& progress) {
  const auto begin = std::chrono::steady_clock::now();
  ViewPicture out;
  out.bytes = pngOf(job.job, drawn, volumes_.first(), progress);
  out.type = "image/png";
  for (const DrawnView& view : drawn.views) out.width += view.image.width;
  out.height = drawn.views.front().image.height;
  out.statistics = std::move(drawn.statistics);
  out.seconds = out.statistics.wall_s + secondsSince(begin);
  return out;
}

double ViewPainter::exactSeconds(const ImageSize& size) const {
  if (exact_pixel_s_ == 0) return std::numeric_limits<double>::infinity();
  return exact_pixel_s_ * pixelsOf(size);
}

double ViewPainter::renderSeconds(const ViewedJob& job) const {
  if (costOf(job) != exact_cost_) return std::numeric_limits<double>::infinity();
  return exactSeconds(job.job.picture.size) * static_cast<double>(framesOf(job.job).size());
}

}  // namespace kiln
