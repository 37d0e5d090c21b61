#include "sequence/sheet/gallery.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "base/error.h"
#include "base/file/path_name.h"
#include "base/thread/parallel.h"
#include "frame/empty_frame.h"
#include "image/display.h"
#include "image/thumbnail_sheet.h"
#include "job/frame/frame_scene.h"
#include "job/job_facts.h"
#include "job/job_names.h"
#include "scene/transfer/presets.h"
#include "sequence/frame_requests.h"
#include "sequence/opened_job.h"
#include "store/manifest/read_manifest.h"

namespace kiln {
namespace {

constexpr int kThumbnailSamples = 1;

SheetLayout layoutOf(std::size_t presets, int thumbnail_px) {
  return {.columns = static_cast<int>(galleryViews().size()),
          .rows = static_cast<int>(presets),
          .width = thumbnail_px,
          .height = thumbnail_px,
          .title = true};
}

// One camera for each column.
CameraKeyframes viewsOfRow() {
  CameraKeyframes out;
  const auto add = [&](CameraSpec camera) {
    out.keys.push_back({static_cast<double>(out.keys.size() + 1), {}, std::move(camera)});
  };
  add({});
  for (const Side side : {Side::kFront, Side::kLeft, Side::kTop}) {
    CameraSpec camera;
    camera.side = side;
    add(camera);
  }
  return out;
}

struct Thumbnails {
  std::string preset;
  std::vector<Image> pictures;
  int shown = 0;
};

class GalleryPainter {
 public:
  GalleryPainter(const GalleryRequest& request, std::size_t presets, Progress& progress)
      : progress_(progress),
        job_(jobOf(request)),
        volumes_(job_),
        total_(presets * galleryViews().size()),
        memory_(memoryOf(job_, volumes_.all(), SceneOfJob(job_, volumes_.manifests()),
                         layoutOf(presets, request.thumbnail_px).bytes())),
        cache_(volumes_.all(), cacheBytes(memory_, job_.speed.memory_bytes, job_.volume), readersOfCache()) {}

  CacheCounts counts() const { return cache_.counts(); }
  const FitReads& fit() const { return fit_; }

  Thumbnails draw(const std::string& preset) {
    Thumbnails out{preset, {}, 0};
    job_.picture.transfer_function = preset;
    const SceneOfJob scenes(job_, volumes_.manifests(), sceneInputsOf(job_, volumes_, fit_, progress_));
    for (int view = 1; view <= static_cast<int>(galleryViews().size()); ++view) {
      progress_.throwIfCancelled("drawing a gallery");
      const FrameScene scene = scenes.at(view);
      FrameStatistics statistics;
      Progress silent;
      FrameRequest request = requestOf(scene, job_.speed, memory_);
      request.last_illumination = &illumination_;
      volumes_.dress(request);
      Image picture = renderFrame(cache_, request, silent, statistics);
      show(displayOf(scene.picture), picture);
      out.pictures.push_back(std::move(picture));
      if (isVisible(out.pictures.back())) ++out.shown;
      progress_.advance("drawing", "thumbnails", ++done_, total_);
    }
    return out;
  }

 private:
  static RenderJob jobOf(const GalleryRequest& request) {
    RenderJob out;
    out.volume = request.store;
    out.speed = request.speed;
    out.picture.size = {request.thumbnail_px, request.thumbnail_px};
    out.picture.samples = kThumbnailSamples;
    setLook(request.look, out.picture);
    out.animation.camera = viewsOfRow();
    return out;
  }

  Progress& progress_;
  RenderJob job_;
  const OpenedVolumes volumes_;
  const std::uint64_t total_;
  std::uint64_t done_ = 0;
  FitReads fit_;
  std::shared_ptr<const Illumination> illumination_;  // ambient occlusion is equal from all sides
  const FrameMemory memory_;
  BrickCache cache_;
};

Image sheetOf(const std::vector<Thumbnails>& rows, const GalleryRequest& request) {
  ThumbnailSheet sheet(layoutOf(rows.size(), request.thumbnail_px),
                       "kiln render " + withoutTrailingSlash(request.store).filename().string() +
                           optionOf(request.look) + " -o PICTURE.png");
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (std::size_t column = 0; column < galleryViews().size(); ++column) {
      const bool first = column == 0;
      sheet.put(static_cast<int>(column), static_cast<int>(row), rows[row].pictures[column],
                first ? "--tf " + rows[row].preset : galleryViews()[column], first ? kSheetInk : kSheetCaption);
    }
  }
  return std::move(sheet).take();
}

}  // namespace

std::string optionOf(Look look) {
  if (look == Look::kPlain) return "";
  return fmt::format(" --look {}", nameIn(kLookNames, look));
}

const std::vector<std::string>& galleryViews() {
  static const std::vector<std::string> views = {"", "--view front", "--view left", "--view top"};
  return views;
}

Gallery drawGallery(const GalleryRequest& request, Progress& progress) {
  const ThreadLimit threads(request.speed.threads);
  const bool all = request.presets.empty();
  std::vector<std::string> presets = all ? presetNames() : request.presets;
  // On other volumes the preset is a solid box.
  if (all && readManifest(request.store).volume_class != VolumeClass::kLevelSet) std::erase(presets, "levelset");
  GalleryPainter painter(request, presets.size(), progress);
  std::vector<Thumbnails> rows;
  for (const std::string& preset : presets) {
    try {
      Thumbnails row = painter.draw(preset);
      if (row.shown > 0) rows.push_back(std::move(row));
    } catch (const Error& error) {
      // A preset of another kind of volume.
      if (!all || error.code() != ErrorCode::kUsage) throw;
    }
  }
  if (rows.empty())
    throw Error(ErrorCode::kUsage, request.store, "",
                "no preset shows anything of the volume (kiln info prints its values); draw with --tf of your own");
  Gallery out;
  out.sheet = sheetOf(rows, request);
  for (const Thumbnails& row : rows) out.rows.push_back({row.preset, row.shown});
  const CacheCounts counts = painter.counts();
  out.bricks_read = counts.reads + painter.fit().files;
  out.read_bytes = counts.read_bytes + painter.fit().bytes;
  return out;
}

}  // namespace kiln
