#include "convert/convert.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>

#include "base/elapsed.h"
#include "base/file/chosen_disk.h"
#include "base/file/file.h"
#include "cluster/ranks.h"
#include "convert/conversion.h"
#include "convert/manifest_draft.h"
#include "convert/resume/output_directory.h"
#include "convert/resume/source_state.h"
#include "convert/resume_state.h"
#include "convert/store_of_source.h"
#include "ingest/source/placement.h"
#include "store/manifest/float_steps.h"
#include "store/manifest/read_manifest.h"
#include "store/store_writer.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

std::uint64_t brickCount(const Manifest& manifest) {
  std::uint64_t out = 0;
  for (const LevelInfo& level : manifest.levels) out += static_cast<std::uint64_t>(level.bricks.count());
  return out;
}

// True if the finished bricks are worth keeping, because a repeated conversion may succeed. Includes failures for lack
// of memory or threads.
bool mayBeResumed(const std::exception& error) {
  const auto* ours = dynamic_cast<const Error*>(&error);
  if (ours == nullptr) return true;
  const ErrorCode code = ours->code();
  return code == ErrorCode::kCancelled || code == ErrorCode::kNoSpace || code == ErrorCode::kIo ||
         code == ErrorCode::kExists;
}

// Finishes a store whose last byte was written earlier: the store may still need its name, and the journal may still be
// there.
void finishEarlier(OutputDirectory& destination, const fs::path& out, const SourceInfo& info, const Manifest& draft,
                   const ConvertOptions& options, Progress& progress, ConvertReport& report) {
  const fs::path& store = destination.building();
  if (!isStoreOf(store, info, options.memory_bytes))
    throw Error(ErrorCode::kExists, store, "",
                "is a store of another volume, or its source has changed since; give --overwrite");
  const Manifest manifest = readManifest(store);
  if (manifest.brick_size != options.brick_size)
    throw Error(ErrorCode::kExists, store, "",
                fmt::format("is finished, with bricks of {} voxels; give --overwrite to make bricks of {}",
                            manifest.brick_size, options.brick_size));
  if (manifest.levels.size() != draft.levels.size())
    throw Error(ErrorCode::kExists, store, "",
                fmt::format("is finished, with {} levels; give --overwrite to make {}", manifest.levels.size(),
                            draft.levels.size()));
  const bool labels = makesLabels(info, options);
  if ((manifest.volume_class == VolumeClass::kLabels) != labels)
    throw Error(ErrorCode::kExists, store, "",
                labels ? "is a store that was made without --labels; give --overwrite"
                       : "is a store of labels; give --labels, or --overwrite");
  destination.commit();
  progress.note(out.string() + " is finished already");
  report.bricks = brickCount(manifest);
  for (const LevelInfo& level : manifest.levels) {
    report.stored_bricks += level.stored_bricks;
    report.stored_bytes += level.stored_bytes;
  }
  report.nan_count = manifest.nan_count;
}

// Keeps the finished bricks of a failed single-process conversion if resuming can succeed; else removes the bricks.
// With several processes, keeps all files, because processes may still be writing.
void tidyUp(OutputDirectory& destination, const std::exception& error, std::uint64_t finished, std::uint64_t bricks,
            const ConvertOptions& options, Progress& progress) {
  if (finished == 0 || !mayBeResumed(error)) return destination.abandon();
  destination.keepForResuming();
  progress.note(fmt::format("{} of {} bricks are kept in {}; {} to continue", finished, bricks,
                            destination.building().string(),
                            options.overwrite && options.resume ? "run again" : "run again with --resume"));
}

// Makes the bricks; on the first rank, also finishes the store.
class Build {
 public:
  Build(ResumeState& resume_state, const Manifest& draft, const ConversionPlan& plan, const ConvertOptions& options,
        VolumeSource& source, Ranks& ranks, FileSystem& disk, Progress& progress)
      : resume_state_(resume_state),
        draft_(draft),
        budget_(plan),
        options_(options),
        source_(source),
        ranks_(ranks),
        disk_(disk),
        progress_(progress) {}

  void run(ConvertReport& report) {
    StoreWriter& writer = writer_.emplace(resume_state_.directory, draft_, disk_, budget_.sub_ranges_on_disk);
    Conversion& conversion = conversion_.emplace(
        Conversion::Parts{source_, writer, resume_state_.directory, budget_, options_.half, ranks_, disk_, progress_},
        resume_state_.identity, resume_state_.noted > 0);
    const std::uint64_t earlier = conversion.finishedBricks(), bricks = brickCount(writer.manifest());
    if (earlier > 0 && ranks_.first())
      progress_.note(
          fmt::format("{}: {} of {} bricks are finished already", resume_state_.directory.string(), earlier, bricks));
    conversion.run();
    if (ranks_.first()) {
      requireUnchanged();
      writer.finish(histogramOf(writer.manifest(), conversion.counter(), writer.range()),
                    conversion.counter().nanCount());
      report.bricks = bricks;
      report.stored_bricks = writer.storedBricks();
      report.stored_bytes = writer.bytesWritten();
      const double share = 1 - static_cast<double>(earlier) / static_cast<double>(bricks);
      report.voxels = static_cast<std::uint64_t>(share * static_cast<double>(draft_.geometry().dims.count()));
      report.nan_count = conversion.counter().nanCount();
      report.half_error = conversion.halfError();
      if (const std::string merged = mergedValuesText(writer.manifest()); !merged.empty())
        progress_.note(namedNote(source_.info(), merged));
      report.ranks = conversion.rankReports();
    }
    conversion_.reset();
  }

  /// Returns the number of finished bricks on the disk after a failure. cost: frees the lanes' memory.
  std::uint64_t bricksLeft() {
    // Before the conversion has examined the bricks, the journal's number counts.
    const std::uint64_t out = conversion_ ? conversion_->finishedBricks() : resume_state_.noted;
    conversion_.reset();
    return out;
  }
  std::uint64_t bricks() const { return writer_ ? brickCount(writer_->manifest()) : 0; }

 private:
  // A store must not mix bricks of two states of the source.
  void requireUnchanged() const {
    const std::vector<fs::path>& files = source_.info().files;
    if (isStateOf(draft_.source.state, files, source_.info().trees)) return;
    throw Error(ErrorCode::kFormat, lastChanged(files), "",
                "was changed while it was converted, so that bricks of two states were made; convert it again once "
                "no program writes to it");
  }

  ResumeState& resume_state_;
  const Manifest& draft_;
  const ConversionPlan& budget_;
  const ConvertOptions& options_;
  VolumeSource& source_;
  Ranks& ranks_;
  FileSystem& disk_;
  Progress& progress_;
  std::optional<StoreWriter> writer_;
  std::optional<Conversion> conversion_;
};

void runAlone(Build& build, OutputDirectory& destination, const ConvertOptions& options, Progress& progress,
              ConvertReport& report) {
  try {
    build.run(report);
    destination.commit();
  } catch (const std::exception& error) {
    const std::uint64_t left = std::max(build.bricksLeft(), report.bricks);
    tidyUp(destination, error, left, build.bricks(), options, progress);
    throw;
  }
}

void runTogether(Build& build, OutputDirectory* destination, Ranks& ranks, const fs::path& out, ConvertReport& report) {
  try {
    build.run(report);
    if (destination != nullptr) destination->commit();
  } catch (const Error& error) {
    throw Error(error.code(), std::string(error.what()) + "; the finished bricks of " + out.string() +
                                  " are kept; continue by the same command with --resume");
  }
  // No rank reports success before the store exists.
  ranks.barrier();
}

}  // namespace

bool makesLabels(const SourceInfo& info, const ConvertOptions& options) {
  return options.labels || info.volume_class == VolumeClass::kLabels;
}

ConvertReport convert(VolumeSource& source, const fs::path& out, const ConvertOptions& options, Progress& progress) {
  const auto started = std::chrono::steady_clock::now();
  requireBricks(source.info(), options);
  const std::unique_ptr<Ranks> alone = oneRank();
  Ranks& ranks = options.ranks != nullptr ? *options.ranks : *alone;
  FileSystem& disk = chosenDisk(options.disk);
  const SourceInfo& info = source.info();
  requireRoomForIndex(info, options);
  const ConversionPlan plan = planConversion(source, options);
  std::size_t notes = 0;
  if (ranks.first()) {
    for (const std::string& note : info.notes) progress.note(namedNote(info, note));
    notes = info.notes.size();
    if (!ranks.alone() && source.order() == ReadOrder::kForward)
      progress.note(
          namedNote(info, "is a stream, so that each rank reads and unpacks all of it, and they share the rest"));
  }
  source.willRead(*plan.order);
  source.keepDecoded(plan.kept_bytes);
  ConvertReport report;
  Manifest draft = draftOf(info, options);
  requireSameSource(info, draft, ranks);
  std::optional<OutputDirectory> destination;
  ResumeState resume_state;
  if (ranks.first()) {
    destination.emplace(out, options.overwrite, options.resume, disk, options.lock);
    if (!destination->lock().diskHasLocks())
      progress.note("the disk of " + out.string() + " has no locks; let one conversion at a time write there");
    resume_state = beginAt(*destination, draft, options, ranks, disk);
  }
  share(resume_state, ranks);
  draft.source.command = resume_state.identity.command;
  draft.source.time = resume_state.identity.time;
  Build build(resume_state, draft, plan, options, source, ranks, disk, progress);
  if (resume_state.finished) {
    if (destination) finishEarlier(*destination, out, info, draft, options, progress, report);
  } else if (ranks.alone()) {
    runAlone(build, *destination, options, progress, report);
  } else {
    runTogether(build, destination ? &*destination : nullptr, ranks, out, report);
  }
  // A compressed stream adds notes when it ends.
  for (; ranks.first() && notes < info.notes.size(); ++notes) progress.note(namedNote(info, info.notes[notes]));
  if (const std::string note = orientationNote(info); ranks.first() && !note.empty())
    progress.note(namedNote(info, note));
  if (destination && !destination->leftOld().empty()) progress.note(destination->leftOld());
  report.buffer_bytes = plan.total();
  const auto voxels = static_cast<std::uint64_t>(info.geometry.dims.count());
  if (const auto blocks = source.decodedBlocks(); blocks && ranks.alone() && report.voxels == voxels)
    report.decodings =
        static_cast<double>(blocks->decodings) / static_cast<double>(blocks->countIn(info.geometry.dims));
  report.seconds = secondsSince(started);
  return report;
}

}  // namespace kiln
