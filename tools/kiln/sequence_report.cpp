#include "sequence_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "base/duration_text.h"
#include "base/memory/memory.h"
#include "frame/empty_frame.h"
#include "job/frame_list.h"
#include "job/job_facts.h"
#include "say.h"
#include "source_arguments.h"
#include "store/manifest/json_text.h"

namespace kiln::tool {
namespace {

using Json = nlohmann::ordered_json;

void emit(const char* event, const Json& more) {
  Json line = {{"event", event}, {"time", timeNow()}};
  line.update(more);
  sayJson(jsonText(std::move(line), -1) + "\n");
  flush();
}

std::string nameInJson(const std::filesystem::path& path) { return utf8OfName(path.native()); }

// The files of a frame, in a sentence.
std::string namesOfFiles(const RenderJob& job, int frame) {
  const std::vector<OutputFile> files = filesOf(job, frame);
  std::string out = files.front().path.string();
  for (std::size_t i = 1; i < files.size(); ++i)
    out += (i + 1 < files.size() ? ", " : " and ") + files[i].path.string();
  return out;
}

Json pathsOf(const RenderJob& job, int frame) {
  Json out = Json::array();
  for (const OutputFile& file : filesOf(job, frame)) out.push_back(nameInJson(file.path));
  return out;
}

// Returns the reason for an empty frame; null if the frame shows something.
Json emptyJson(const FrameStatistics& frame) {
  return frame.empty == EmptyFrame::kShows ? Json(nullptr) : Json(emptyText(frame.empty));
}

// "1.2 frames/s", or the time per frame if a frame takes more than a second.
std::string rateText(double frames, double seconds) {
  if (!(frames > 0) || !(seconds > 0)) return "";
  return frames >= seconds ? fmt::format("{:.1f} frames/s", frames / seconds)
                           : fmt::format("{} a frame", durationText(seconds / frames));
}

}  // namespace

SequenceReport::SequenceReport(TerminalProgress& progress, ReportKind kind) : progress_(progress), kind_(kind) {
  if (emitsEvents())
    progress_.tellWarnings([](const std::string& sentence) { emit("warning", {{"warning", sentence}}); });
  if (emitsEvents()) progress_.tell([this](const TerminalProgress::Numbers& numbers) { drawingGoesOn(numbers); });
}

SequenceReport::~SequenceReport() {
  progress_.tell({});
  progress_.tellWarnings({});
}

// Progress beside frames has no event.
void SequenceReport::drawingGoesOn(const TerminalProgress::Numbers& numbers) const {
  if (!drawing_) return;
  Json more = {{"frame", *drawing_}, {"done", numbers.done}, {"total", numbers.total}, {"unit", numbers.unit}};
  more["seconds_left"] = numbers.seconds_left ? Json(*numbers.seconds_left) : Json(nullptr);
  emit("frame_progress", more);
}

// A frame of another rank may end while this rank draws.
void SequenceReport::frameEnded(int frame) {
  if (drawing_ == frame) drawing_.reset();
}

double SequenceReport::secondsLeft(std::size_t done) const {
  return drawn_ > 0 ? seconds() / static_cast<double>(drawn_) * static_cast<double>(frames_ - done) : 0;
}

void SequenceReport::started(const RenderJob& job, const std::vector<int>& frames) {
  begin_ = Clock::now();
  frames_ = frames.size();
  if (!emitsEvents()) return;
  Json outputs = Json::array();
  for (const std::filesystem::path& name : namesOf(job.output)) outputs.push_back(nameInJson(name));
  emit("started", {{"volume", nameInJson(job.volume)},
                   {"frames", frames.size()},
                   {"numbers", framesText(frames)},
                   {"outputs", outputs}});
}

void SequenceReport::frameStarted(int frame) {
  drawing_ = frame;
  if (emitsEvents()) emit("frame_started", {{"frame", frame}});
}

void SequenceReport::frameDone(const RenderJob& job, const FrameStatistics& frame, std::size_t done) {
  ++drawn_;
  frameEnded(frame.frame);
  if (emitsEvents())
    return emit("frame_done", {{"frame", frame.frame},
                               {"seconds", frame.wall_s + frame.output_s},
                               {"read_bytes", frame.bricks_read_bytes},
                               {"bricks_read", frame.bricks_read},
                               {"bricks_damaged", frame.bricks_damaged},
                               {"peak_cache_bytes", frame.peak_cache_bytes},
                               {"peak_rss_bytes", frame.peak_rss_bytes},
                               {"empty", emptyJson(frame)},
                               {"files", pathsOf(job, frame.frame)},
                               {"done", done},
                               {"frames", frames_},
                               {"seconds_left", secondsLeft(done)}});
  const std::string line = frameLine(job, frame);
  progress_.clear();
  if (frames_ == 1)
    only_line_ = line;  // printed if all frames succeed
  else
    print(line);
  flush();
  showOverall(done);
}

std::string SequenceReport::frameLine(const RenderJob& job, const FrameStatistics& frame) const {
  const PixelRect drawn = drawnPixels(job.picture.size, job.picture.crop);
  const std::string picture =
      fmt::format("{}: {} x {} pixels{}", namesOfFiles(job, frame.frame), drawn.width(), drawn.height(),
                  frame.samples > 1 ? fmt::format(" of {} samples", frame.samples) : "");
  if (kind_ != ReportKind::kVerbose)
    return fmt::format("{}, {}, {} read, peak {}", picture, durationText(frame.wall_s),
                       formatBytes(frame.bricks_read_bytes), formatBytes(frame.peak_rss_bytes));
  return fmt::format(
      "{} in {}; {} of {} bricks read ({}), {} hidden; {} voxels visited, {} splatted; peak cache {}, resident "
      "{}",
      picture, durationText(frame.wall_s), frame.bricks_read, frame.bricks_total, formatBytes(frame.bricks_read_bytes),
      frame.bricks_hidden, frame.voxels_visited, frame.voxels_splats, formatBytes(frame.peak_cache_bytes),
      formatBytes(frame.peak_rss_bytes));
}

void SequenceReport::print(const std::string& line) const {
  if (kind_ != ReportKind::kQuiet) say("{}\n", line);
}

void SequenceReport::frameKept(const RenderJob& job, int frame, std::size_t done) {
  ++kept_;
  if (emitsEvents())
    return emit("frame_kept", {{"frame", frame}, {"files", pathsOf(job, frame)}, {"done", done}, {"frames", frames_}});
  if (frames_ == 1) only_line_ = namesOfFiles(job, frame) + ": kept; it is there and whole";
  showOverall(done);
}

void SequenceReport::frameFailed(int frame, const Error& error, std::size_t done) {
  frameEnded(frame);
  if (emitsEvents())
    return emit("frame_failed", {{"frame", frame}, {"error", error.what()}, {"done", done}, {"frames", frames_}});
  progress_.note(fmt::format("frame {} failed: {}", frame, error.what()));
  showOverall(done);
}

void SequenceReport::showOverall(std::size_t done) {
  if (frames_ <= 1 || done == frames_) return progress_.show("", "");
  const std::string rate = rateText(static_cast<double>(drawn_), seconds());
  const std::string count = fmt::format("{} of {} frames", done, frames_);
  const std::string kept = kept_ > 0 ? fmt::format(", {} kept", kept_) : "";
  const std::string left = rate.empty() ? "" : fmt::format(", {} left", roughDurationText(secondsLeft(done)));
  progress_.show(count + kept + (rate.empty() ? "" : ", " + rate) + left, count + left);
}

void SequenceReport::finished(const RenderJob& job, const SequenceResult& result) {
  const RenderStatistics& s = result.statistics;
  progress_.clear();
  const std::filesystem::path& video = job.output.video.path;
  if (emitsEvents())
    return emit("finished", {{"frames", frames_},
                             {"drawn", s.frames.size()},
                             {"kept", s.kept.size()},
                             {"failed", s.failed},
                             {"video", s.failed.empty() && !video.empty() ? Json(nameInJson(video)) : Json(nullptr)},
                             {"seconds", seconds()}});
  if (!only_line_.empty()) print(only_line_);
  if (frames_ > 1) {
    const std::string rate = rateText(static_cast<double>(drawn_), seconds());
    print(fmt::format("{} frames in {}{}: {} drawn, {} kept, {} failed", frames_, durationText(seconds()),
                      rate.empty() ? "" : fmt::format(" ({})", rate), s.frames.size(), s.kept.size(), s.failed.size()));
  }
  if (!video.empty() && s.failed.empty())
    print(fmt::format("{}: {} frames, {} a second", video.string(), frames_, job.output.video.rate.text()));
}

void SequenceReport::ended(const Error& error) {
  if (emitsEvents())
    emit(error.code() == ErrorCode::kCancelled ? "interrupted" : "failed",
         {{"error", error.what()}, {"drawn", drawn_}, {"kept", kept_}, {"frames", frames_}, {"seconds", seconds()}});
}

}  // namespace kiln::tool
