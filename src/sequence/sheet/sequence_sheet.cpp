#include "sequence/sheet/sequence_sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <variant>

#include "base/error.h"
#include "base/thread/parallel.h"
#include "base/thread/trace.h"
#include "frame/background.h"
#include "frame/empty_frame.h"
#include "frame/pass/frame_progress.h"
#include "image/file/image_file.h"
#include "image/srgb.h"
#include "image/thumbnail_sheet.h"
#include "job/frame_list.h"
#include "job/job_facts.h"
#include "job/stereo.h"
#include "sequence/frame_annotations.h"
#include "sequence/series_volumes.h"

namespace kiln {
namespace {

SheetLayout layoutOf(const RenderJob& job) {
  const auto frames = static_cast<int>(framesOf(job).size());
  const PixelRect drawn = drawnPixels(job.picture.size, job.picture.crop);
  // Columns and rows of the sheet are about equally long.
  const double square = std::sqrt(frames * double(drawn.height()) / drawn.width());
  SheetLayout out;
  out.columns = std::clamp(static_cast<int>(std::ceil(square)), 1, frames);
  out.rows = (frames + out.columns - 1) / out.columns;
  out.width = drawn.width(), out.height = drawn.height();
  return out;
}

}  // namespace

std::vector<int> framesOfSheet(const RenderJob& job, int count) {
  const std::vector<int> frames = framesOf(job);
  const auto shown = static_cast<std::size_t>(count);
  if (frames.size() <= shown) return frames;
  // The last frame of a full turn is a step before the first frame.
  const auto* const turn = std::get_if<Turntable>(&job.animation.camera);
  const bool turns =
      turn && std::fmod(turn->degrees, 360) == 0 && frames.size() == static_cast<std::size_t>(turn->frames);
  std::vector<int> out;
  for (std::size_t i = 0; i < shown; ++i)
    out.push_back(frames[turns || shown == 1 ? i * frames.size() / shown
                                             : (i * (frames.size() - 1) + (shown - 1) / 2) / (shown - 1)]);
  return out;
}

void requireSheet(const RenderJob& job) {
  const auto refuse = [](const std::string& why) { throw Error(ErrorCode::kUsage, "--sheet: " + why); };
  if (framesOf(job).size() < 2)
    refuse("a sheet shows frames of a sequence (found 1); add --turntable 120, or give a job with frames");
  if (job.output.path.empty() || !job.output.files.empty() || !job.output.video.path.empty())
    refuse(
        "a sheet is one picture, such as .exr or .png, and the job has other outputs; name the sheet by -o and leave "
        "outputs out");
  const bool of_eye = job.picture.stereo && hasEyePlace(job.output.path);
  if (of_eye || hasFramePlace(job.output.path))
    refuse(fmt::format("a sheet is one picture (found {}, one for each {}); name the sheet by -o, as in -o sheet.png",
                       job.output.path.string(), of_eye ? "eye" : "frame"));
  if (drawsDeep(job) || drawsPart(job.picture) || job.picture.aovs.any())
    refuse("a sheet holds colours alone; leave --deep, --part and --aov out");
  if (drawsBothEyes(job.picture.stereo)) refuse("a sheet shows one eye (found both); choose --stereo left or right");
  const SheetLayout layout = layoutOf(job);
  if (std::max(layout.sheetWidth(), layout.sheetHeight()) > kLargestSide_px)
    refuse(fmt::format("the sheet's sides are at most {} pixels (found {}x{}); give a smaller --size", kLargestSide_px,
                       layout.sheetWidth(), layout.sheetHeight()));
  requireSides(job.output.path, layout.sheetWidth(), layout.sheetHeight());
}

Image drawSequenceSheet(const RenderJob& given, const StoreFor& store_for, Progress& progress) {
  const ThreadLimit threads(given.speed.threads);
  RenderJob job = given;
  if (!job.series) job.series = seriesLook(job, store_for);
  if (job.series) progress.note(job.series->choice);
  std::optional<Trace> trace;
  if (!job.trace.empty()) trace.emplace(job.trace);
  const SheetLayout layout = layoutOf(job);
  ThumbnailSheet sheet(layout);
  SequenceFrames frames(job, store_for, progress, layout.bytes(), {.has_files = false});
  frames.requireScenes();
  UncountedProgress of_frames(progress);
  const std::vector<int>& numbers = frames.numbers();
  std::vector<FrameStatistics> statistics;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    progress.throwIfCancelled("drawing a sheet");
    OpenedJob& opened = frames.openedFor(numbers[i]);
    DrawnFrame drawn = opened.draw(numbers[i], of_frames);
    opened.judge(drawn);
    noteDamage(drawn.statistics, progress);
    Image& picture = drawn.views.front().image;
    const int first_row = drawnPixels(job.picture.size, job.picture.crop).y0;
    finishPicture(picture, first_row, finishOf(drawn.scene.picture, drawn.scene.transfer_function),
                  mediumOf(job.output.path));
    // A sheet holds colours alone, also in an EXR. Annotations are legible on its paper.
    drawn.scene.picture.background = overPaper(backgroundOf(drawn.scene.picture, drawn.scene.transfer_function),
                                               linearFromSrgb(ThumbnailSheet::paper()));
    const Annotators annotators = annotatorsOf(opened.job(), drawn);
    if (annotators.front()) annotators.front()->over(picture, 0, first_row, depthOf(picture));
    const auto place = static_cast<int>(i);
    sheet.put(place % layout.columns, place / layout.columns, picture, fmt::format("{}", numbers[i]));
    statistics.push_back(std::move(drawn.statistics));
    progress.advance("drawing", "frames", i + 1, numbers.size());
  }
  if (trace) trace->finish();
  warnOfDoubtfulFrames(statistics, true, progress);
  return std::move(sheet).take();
}

}  // namespace kiln
