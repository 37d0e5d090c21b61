#include "sequence/ranked_sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "cluster/agreement.h"
#include "cluster/shared_lists.h"
#include "job/job_facts.h"
#include "sequence/rank_facts.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::int32_t kNoError = -1;

// Path of a volume's store, or the message of the error for which there is none.
struct SharedStore {
  std::string text;
  std::int32_t error = kNoError;
};

// `fails_alone`: a volume file that cannot be converted fails the frames that show the volume, and no other frame.
SharedStore storeOf(const fs::path& volume, const StoreFor& store_for, bool fails_alone) {
  try {
    return {(store_for ? store_for(volume) : volume).string()};
  } catch (const Error& error) {
    if (!fails_alone || error.code() == ErrorCode::kCancelled) throw;
    return {error.what(), static_cast<std::int32_t>(error.code())};
  }
}

}  // namespace

RankedSequence::RankedSequence(const RenderJob& job, const SequenceOptions& options, StoreFor stores,
                               Progress& progress, SequenceListener& listener, std::optional<VoxelBox> part,
                               bool share_reads)
    : job_(job),
      ranks_(*options.ranks),
      progress_(progress),
      shared_reads_(share_reads ? std::make_unique<SharedReads>(ranks_) : nullptr),
      // In a time series each rank has volumes of its own.
      frames_(job, std::move(stores), progress, besideBytes(job, options),
              {part, shared_reads_.get(), ranks_.first() || isSeries(job)}),
      resume_(options.resume),
      listener_(listener) {}

SequenceResult RankedSequence::run() {
  if (ranks_.first()) frames_.makeFolders();
  frames_.requireScenes();
  requireAgreement(ranks_, frameFacts(job_, frames_.stores()));
  if (ranks_.first()) listener_.started(job_, frames_.numbers());
  findKept();
  // The files of one of several frames are tested when the frame is drawn.
  if (ranks_.first() && single() && !to_draw_.empty()) requirePlaces(job_, to_draw_.front());
  try {
    if (!to_draw_.empty()) shareAndRead();
  } catch (const Error& error) {
    // All ranks are cancelled, and one rank reports, perhaps without the number of finished frames.
    if (error.code() == ErrorCode::kCancelled && !single()) throw frames_.interrupted(std::nullopt);
    throw;
  }
  finish();
  return std::move(result_);
}

// A rank that fails here ends all ranks, because messages to the rank would wait without end.
void RankedSequence::shareAndRead() {
  try {
    share();
    if (shared_reads_) shared_reads_->finish();
  } catch (...) {
    if (shared_reads_) shared_reads_->abandon();
    throw;
  }
}

// A frame that cannot be opened is not kept, and fails when it is drawn.
bool RankedSequence::isKept(int frame) {
  try {
    if (!frames_.isThere(frame)) return false;
  } catch (const Error& error) {
    if (single() || error.code() == ErrorCode::kExists || error.code() == ErrorCode::kCancelled) throw;
    return false;
  }
  frames_.removeLeftovers(frame);
  return true;
}

// Each rank tests some of the frames, because a test reads the whole file.
void RankedSequence::findKept() {
  std::vector<int> kept;
  const std::vector<int>& numbers = frames_.numbers();
  if (resume_) {
    // One rank looks for the video, and answers for all frames in it.
    if (ranks_.first()) frames_.findVideo();
    const std::size_t count = frames_.areInVideo() ? 1 : static_cast<std::size_t>(ranks_.count());
    for (auto i = static_cast<std::size_t>(ranks_.rank()); i < numbers.size(); i += count) {
      if (isKept(numbers[i])) kept.push_back(numbers[i]);
    }
  }
  kept = gatherLists(ranks_, kept);
  broadcastList(ranks_, kept);
  for (const int frame : numbers) {
    if (std::find(kept.begin(), kept.end(), frame) == kept.end()) {
      to_draw_.push_back(frame);
      continue;
    }
    result_.statistics.kept.push_back(frame);
    ++done_;
    if (ranks_.first()) listener_.frameKept(job_, frame, done_);
  }
}

void RankedSequence::attempt(FrameReport& report, const std::function<void()>& body) {
  const int frame = to_draw_[report.frame];
  try {
    progress_.throwIfCancelled("rendering");
    body();
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kCancelled) throw;
    if (single()) throw Error(error.code(), fmt::format("frame {}: {}", frame, error.what()));
    report.failure = Error(error.code(), fmt::format("rank {}: {}", ranks_.rank(), error.what()));
  }
  report.statistics.frame = frame;
}

void RankedSequence::write(OpenedJob& opened, std::uint32_t frame, DrawnFrame& drawn) {
  opened.judge(drawn);
  writeFrame(frames_.jobToWrite(opened), to_draw_[frame], drawn, opened.firstVolume(), opened.memory().files);
  ++own_.frames_written;
}

void RankedSequence::started(std::uint32_t frame) {
  if (ranks_.first()) listener_.frameStarted(to_draw_[frame]);
}

void RankedSequence::record(const FrameReport& report) {
  ++recorded_;
  ++done_;
  const int frame = to_draw_[report.frame];
  if (report.failure) {
    if (result_.statistics.failed.empty()) result_.first_failure = report.failure->what();
    result_.statistics.failed.push_back(frame);
    listener_.frameFailed(frame, *report.failure, done_);
    return;
  }
  noteDamage(report.statistics, progress_);
  listener_.frameDone(job_, report.statistics, done_);
  result_.statistics.add(report.statistics);
}

void RankedSequence::finish() {
  own_.rank = ranks_.rank();
  const RankTraffic traffic = ranks_.traffic();
  own_.sent_bytes = traffic.sent_bytes;
  own_.received_bytes = traffic.received_bytes;
  if (shared_reads_) own_.setReads(shared_reads_->counts());
  RenderStatistics& s = result_.statistics;
  s.ranks = gatherLists(ranks_, std::vector<RankStatistics>{own_});
  if (ranks_.first()) {
    s.shared_by = sharedBy();
    frames_.describeMemory(s);
    std::sort(s.failed.begin(), s.failed.end());
    std::sort(s.frames.begin(), s.frames.end(), [](const auto& a, const auto& b) { return a.frame < b.frame; });
    if (s.failed.empty()) frames_.makeVideo();
  }
  ranks_.barrier();
}

StoreFor sharedStores(const RenderJob& job, const SequenceOptions& options) {
  std::map<fs::path, SharedStore> stores;
  const std::vector<int> frames = framesOf(job);
  const bool fails_alone = isSeries(job) && frames.size() > 1;
  for (const int frame : frames) {
    for (const fs::path& volume : inputVolumesOf(jobAtFrame(job, frame))) {
      if (stores.contains(volume)) continue;
      SharedStore store;
      if (options.ranks->first()) store = storeOf(volume, options.store_for, fails_alone);
      std::vector<char> letters(store.text.begin(), store.text.end());
      broadcastList(*options.ranks, letters);
      std::vector<std::int32_t> code{store.error};
      broadcastList(*options.ranks, code);
      stores[volume] = {{letters.begin(), letters.end()}, code.front()};
    }
  }
  return [stores](const fs::path& volume) {
    const SharedStore& store = stores.at(volume);
    if (store.error != kNoError) throw Error(static_cast<ErrorCode>(store.error), store.text);
    return fs::path(store.text);
  };
}

}  // namespace kiln
