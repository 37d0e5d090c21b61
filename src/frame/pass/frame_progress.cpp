#include "frame/pass/frame_progress.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

namespace kiln {
namespace {

constexpr const char* kDrawing = "drawing";  // the step of a part

}  // namespace

PartProgress::PartProgress(Progress& progress, const char* unit, std::uint64_t total)
    : progress_(progress), unit_(unit), total_(total) {
  if (total_ > 0) progress_.advance(kDrawing, unit_, 0, total_);
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
  progress_.advance(kDrawing, unit_, done, total_);
}

void PartProgress::finish() {
  if (total_ > 0) progress_.advance(kDrawing, unit_, total_, total_);
}

FrameProgress::FrameProgress(int frame, std::uint64_t total, Progress& progress)
    : step_(stepOfFrame(frame)), total_(total), progress_(progress) {}

ViewsProgress::ViewsProgress(const char* step, std::uint64_t rows, Progress& progress)
    : step_(step), rows_(rows), progress_(progress) {
  progress_.advance(step_, "rows", 0, rows_);
}

// `end` alone reports the total.
void ViewsProgress::advance(const char* /*step*/, const char* /*unit*/, std::uint64_t done, std::uint64_t total) {
  if (done < total) progress_.advance(step_, "rows", before_ + of_part_ * done / total, rows_);
}

void ViewsProgress::end() {
  before_ += of_part_;
  progress_.advance(step_, "rows", before_, rows_);
}

void FrameProgress::advance(const char* step, const char* unit, std::uint64_t done, std::uint64_t total) {
  if (std::string_view(step) != kDrawing) return progress_.advance(step, unit, done, total);
  progress_.advance(step_.c_str(), unit, before_ + done, std::max(total_, before_ + total));
  if (done == total) before_ += total;
}

std::string stepOfFrame(int frame) { return fmt::format("frame {}", frame); }

}  // namespace kiln
