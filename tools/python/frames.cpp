// The frames of a job, drawn one by one, or all to files as `kiln render JOB.json` does.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <set>
#include <utility>

#include "base/find_program.h"
#include "base/thread/parallel.h"
#include "frame/empty_frame.h"
#include "job/job_facts.h"
#include "python/modules.h"
#include "python/volume.h"
#include "sequence/sequence.h"
#include "sequence/sequence_frames.h"
#include "sequence/series_volumes.h"

namespace kiln::python {
namespace {

// thread: one call at a time, which Turn ensures.
class Frames {
 public:
  // `volumes` are open volumes of the job, or none: then the job's stores and files are opened.
  Frames(RenderJob job, std::filesystem::path store_directory,
         std::vector<std::shared_ptr<const BrickedVolume>> volumes)
      : job_(std::move(job)),
        numbers_(framesOf(job_)),
        labels_(labelVolumesOf(job_)),
        store_directory_(std::move(store_directory)),
        volumes_(std::move(volumes)) {
    requirePart(job_);
    requireVolumes(job_);
    requireViews(job_);
    requireEngineOptions(job_.picture);
    if (!job_.output.video.path.empty()) job_.output.video.encoder = encoderOfVideo();
  }

  std::size_t count() const { return numbers_.size(); }

  // Draws the next frame and writes its files, if the job names any. Null after the last frame.
  std::shared_ptr<Picture> next(Progress& progress) {
    if (place_ == numbers_.size()) return nullptr;
    const ThreadLimit threads(job_.speed.threads);
    const Relay::Scope scope(relay_, progress);
    const int frame = numbers_[place_];
    OpenedJob& opened = openedFor(frame);
    DrawnFrame drawn = opened.draw(frame, progress);
    opened.judge(drawn);
    noteDamage(drawn.statistics, progress);
    warnOfDoubtfulFrames({drawn.statistics}, numbers_.size() > 1, progress);
    auto out = std::make_shared<Picture>(opened.job(), frame, std::move(drawn), opened.firstVolume().share());
    out->writeFiles();
    if (place_ + 1 == numbers_.size() && frames_ && hasFiles()) frames_->makeVideo();
    ++place_;
    return out;
  }

  // Draws all frames to files. Returns the numbers of frames drawn, kept and failed.
  SequenceResult run(bool resume, bool checkpoint, Progress& progress) {
    if (!volumes_.empty())
      throw Error(ErrorCode::kUsage, "run: needs stores or volume files (found open volumes); iterate over the frames");
    if (!hasFiles())
      throw Error(ErrorCode::kUsage, "output: names no file for the frames; give one, or iterate over them");
    SequenceOptions options;
    options.resume = resume;
    options.checkpoint = checkpoint;
    options.store_for = [&](const std::filesystem::path& volume) { return storeOf(volume, progress); };
    SequenceListener silent;
    return runSequence(job_, options, progress, silent);
  }

  // A call of Python, as long as it lasts. A call during another is refused, as by Python's generators: the lock of
  // Python is free while a frame is drawn, and `on_progress` may call. thread: holds the lock.
  class Turn {
   public:
    Turn(Frames& frames, const char* call) : frames_(frames) {
      if (frames_.in_call_)
        throw Error(ErrorCode::kUsage, std::string(call) +
                                           ": expected one call at a time (found a call under way); ask for frames "
                                           "from one thread, or make frames for each thread");
      frames_.in_call_ = true;
    }
    ~Turn() { frames_.in_call_ = false; }
    Turn(const Turn&) = delete;
    Turn& operator=(const Turn&) = delete;

   private:
    Frames& frames_;
  };

 private:
  // throws: Error kUsage for a video that cannot be made, kNotFound without the program.
  std::filesystem::path encoderOfVideo() const {
    const std::filesystem::path& video = job_.output.video.path;
    if (numbers_.size() == 1 && job_.frames.empty())
      throw Error(ErrorCode::kUsage, video, "",
                  "a video needs frames (found 1); give the camera a turntable or key frames");
    if (!volumes_.empty())
      throw Error(ErrorCode::kUsage, video, "",
                  "a video needs stores or volume files (found open volumes); name their files in the job");
    std::filesystem::path encoder = findProgram("ffmpeg");
    if (encoder.empty())
      throw Error(ErrorCode::kNotFound, video, "",
                  "a video needs the program ffmpeg, which is in no absolute folder of PATH; install it, or write "
                  "pictures");
    return encoder;
  }

  bool hasFiles() const { return !namesOf(job_.output).empty(); }

  std::filesystem::path storeOf(const std::filesystem::path& volume, Progress& progress) const {
    return storeForCall(volume, SourceWords(), store_directory_, labels_.contains(volume), job_.speed.memory_bytes,
                        progress);
  }

  OpenedJob& openedFor(int frame) {
    if (!volumes_.empty()) {
      if (!opened_) {
        opened_ = std::make_unique<OpenedJob>(job_, OpenedVolumes(job_, pointersTo(volumes_)), relay_);
        for (const Doubt& doubt : opened_->doubts()) relay_.warn(doubt.sentence);
        if (hasFiles()) requireOutputs(job_, numbers_);
      }
      return *opened_;
    }
    if (!frames_) {
      const StoreFor store_for = [this](const std::filesystem::path& volume) { return storeOf(volume, relay_); };
      if (!job_.series) job_.series = seriesLook(job_, store_for);
      if (job_.series) relay_.note(job_.series->choice);
      frames_ = std::make_unique<SequenceFrames>(job_, store_for, relay_, 0, FramesRole{.has_files = hasFiles()});
      if (hasFiles()) frames_->makeFolders();
      frames_->requireScenes();
    }
    return frames_->openedFor(frame);
  }

  RenderJob job_;
  const std::vector<int> numbers_;
  const std::set<std::filesystem::path> labels_;  // volumes that hold labels
  const std::filesystem::path store_directory_;
  const std::vector<std::shared_ptr<const BrickedVolume>> volumes_;
  bool in_call_ = false;  // guarded by Python's lock
  std::size_t place_ = 0;
  Relay relay_;
  std::unique_ptr<SequenceFrames> frames_;
  std::unique_ptr<OpenedJob> opened_;
};

}  // namespace

void bindFrames(py::module_& module) {
  py::class_<Frames, UnlockedPointer<Frames>>(module, "Frames")
      .def_static("of_file",
                  [](const std::filesystem::path& path, const std::filesystem::path& store) {
                    return UnlockedPointer<Frames>(new Frames(readJob(path), store, {}));
                  })
      .def_static("of_text",
                  [](const std::string& json, const std::filesystem::path& store, const std::vector<Volume*>& volumes) {
                    std::vector<std::shared_ptr<const BrickedVolume>> bricks;
                    for (const Volume* volume : volumes) bricks.push_back(volume->bricks());
                    return UnlockedPointer<Frames>(new Frames(parseJob(json, {}), store, std::move(bricks)));
                  })
      .def_property_readonly("count", &Frames::count)
      .def("next",
           [](Frames& self, const py::object& on_progress) {
             const Frames::Turn turn(self, "next");
             return resultForCall(on_progress, [&](Progress& progress) { return self.next(progress); });
           })
      .def("run", [](Frames& self, bool resume, bool checkpoint, const py::object& on_progress) {
        const Frames::Turn turn(self, "run");
        const SequenceResult result =
            resultForCall(on_progress, [&](Progress& progress) { return self.run(resume, checkpoint, progress); });
        std::vector<int> drawn;
        for (const FrameStatistics& frame : result.statistics.frames) drawn.push_back(frame.frame);
        return py::make_tuple(drawn, result.statistics.kept, result.statistics.failed, result.first_failure);
      });
}

}  // namespace kiln::python
