#include "frame/pass/frame_progress.h"

#include <fmt/format.h>

#include <algorithm>

namespace kiln {

PartProgress::PartProgress(Progress& progress, const char* unit, std::uint64_t total)
    : progress_(progress), unit_(unit), total_(total) {
  if (total_ > 0) progress_.advance("drawing", unit_, 0, total_);
}

void PartProgress::reached(std::uint64_t done) {
  reached_ = done;
  const std::lock_guard lock(telling_);
  tell(done);
}

void PartProgress::within(std::uint64_t count, std::uint64_t drawn, std::uint64_t of) {
  // If another thread is reporting, the thread continues with its work.
  const std::unique_lock lock(telling_, std::try_to_lock);
  if (lock) tell(reached_ + count * drawn / of);
}

// `finish` alone reports the total.
void PartProgress::tell(std::uint64_t done) {
  if (done <= told_ || done >= total_) return;
  told_ = done;
  progress_.advance("drawing", unit_, done, total_);
}

void PartProgress::finish() {
  if (total_ > 0) progress_.advance("drawing", unit_, total_, total_);
}

FrameProgress::FrameProgress(int frame, std::uint64_t total, Progress& progress)
    : step_(stepOfFrame(frame)), total_(total), progress_(progress) {}

void FrameProgress::advance(const char* /*step*/, const char* unit, std::uint64_t done, std::uint64_t total) {
  progress_.advance(step_.c_str(), unit, before_ + done, std::max(total_, before_ + total));
  if (done == total) before_ += total;
}

std::string stepOfFrame(int frame) { return fmt::format("frame {}", frame); }

}  // namespace kiln
