#include "base/thread/trace.h"

#include <fmt/format.h>

#include <atomic>
#include <span>

#include "base/file/file.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Checked before the temporary file, so the error names the user's file.
fs::path placeOf(const fs::path& path) {
  FileSystem::real().requirePlaceFor(path);
  return isWrittenInPlace(path) ? path : behindLinks(path);
}

// The longest event is far below the 64 KiB left free, so the buffer never grows.
constexpr std::size_t kFlushedBytes = Trace::kMemoryBytes - (std::size_t{64} << 10);

std::atomic<Trace*> active_trace = nullptr;
std::atomic<std::uint64_t> trace_count = 0;

struct ThreadTrack {
  const char* name = "draws";
  std::uint64_t trace = 0;
  int track = 0;
};
thread_local ThreadTrack own_track;

}  // namespace

Trace::Trace(const fs::path& path)
    : path_(placeOf(path)),
      temporary_(isWrittenInPlace(path_) ? nullptr : std::make_unique<TemporaryFile>(path_)),
      begin_(std::chrono::steady_clock::now()),
      number_(++trace_count) {
  waiting_.reserve(kMemoryBytes);
  waiting_ = "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[\n";
  flush();
  if (failure_) std::rethrow_exception(failure_);
  own_track.name = "frame";
  waiting_ = R"({"name":"process_name","ph":"M","pid":1,"args":{"name":"kiln"}})";
  active_trace = this;
}

Trace::~Trace() { active_trace = nullptr; }

void Trace::finish() {
  active_trace = nullptr;
  const std::lock_guard lock(mutex_);
  waiting_ += "\n]}\n";
  if (!failure_) flush();
  if (failure_) std::rethrow_exception(failure_);
  if (temporary_) FileSystem::real().rename(temporary_->path(), path_);
}

Trace* Trace::active() noexcept { return active_trace.load(std::memory_order_acquire); }

std::int64_t Trace::nowNs() const noexcept {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - begin_).count();
}

void Trace::add(const TracedScope& span, std::string_view notes) noexcept {
  const std::lock_guard lock(mutex_);
  if (failure_) return;
  try {
    const auto us = [](std::int64_t ns) { return 1e-3 * static_cast<double>(ns); };
    put(fmt::format(
        R"({{"name":"{}","cat":"{}","ph":"X","pid":1,"tid":{},"ts":{:.3f},"dur":{:.3f},"args":{{"busy_us":{:.3f}{}}}}})",
        nameOf(span.activity), works(span.activity) ? "work" : "rest", trackOfThread(), us(span.begin_ns),
        us(span.end_ns - span.begin_ns), us(span.busy_ns), notes));
  } catch (...) {
    failure_ = std::current_exception();
  }
}

void Trace::nameThread(const char* name) noexcept { own_track.name = name; }

// The first scope of a thread names its track.
int Trace::trackOfThread() {
  if (own_track.trace != number_) {
    own_track.trace = number_;
    own_track.track = ++tracks_;
    put(fmt::format(R"({{"name":"thread_name","ph":"M","pid":1,"tid":{0},"args":{{"name":"{1} {0}"}}}})",
                    own_track.track, own_track.name));
  }
  return own_track.track;
}

void Trace::put(std::string_view event) {
  waiting_ += ",\n";
  waiting_ += event;
  if (waiting_.size() >= kFlushedBytes) flush();
}

void Trace::flush() {
  try {
    FileSystem::real().appendFile(temporary_ ? temporary_->path() : path_, bytesOf(waiting_));
    waiting_.clear();
  } catch (const Error& error) {
    failure_ = std::make_exception_ptr(temporary_ ? temporary_->named(error) : error);
    temporary_.reset();
  }
}

}  // namespace kiln
