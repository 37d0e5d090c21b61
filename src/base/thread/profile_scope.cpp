#include "base/thread/profile_scope.h"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <ctime>

#include "base/text.h"
#include "base/thread/trace.h"

namespace kiln {
namespace {

thread_local ProfileScope* innermost = nullptr;
std::array<std::atomic<std::int64_t>, kActivities> busy_ns{};

std::int64_t threadTimeNs() noexcept {
  std::timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

}  // namespace

std::string_view nameOf(Activity activity) {
  constexpr std::array<std::string_view, kActivities> kNames = {"frame", "plan",  "walk", "wait",   "read", "decode",
                                                                "brick", "cells", "tile", "finish", "write"};
  return kNames[static_cast<std::size_t>(activity)];
}

double BusyTimes::total() const {
  double sum = 0;
  for (std::size_t i = 0; i < kActivities; ++i) sum += works(static_cast<Activity>(i)) ? seconds[i] : 0;
  return sum;
}

BusyTimes BusyTimes::since(const BusyTimes& earlier) const {
  BusyTimes out;
  for (std::size_t i = 0; i < kActivities; ++i) out.seconds[i] = seconds[i] - earlier.seconds[i];
  return out;
}

void BusyTimes::add(const BusyTimes& other) {
  for (std::size_t i = 0; i < kActivities; ++i) seconds[i] += other.seconds[i];
}

BusyTimes BusyTimes::now() {
  BusyTimes out;
  for (std::size_t i = 0; i < kActivities; ++i)
    out.seconds[i] = 1e-9 * static_cast<double>(busy_ns[i].load(std::memory_order_relaxed));
  return out;
}

ProfileScope::ProfileScope(Activity activity) noexcept
    : activity_(activity), trace_(Trace::active()), around_(innermost) {
  innermost = this;
  if (trace_ != nullptr) begin_ns_ = trace_->nowNs();
  cpu_begin_ns_ = threadTimeNs();
}

ProfileScope::~ProfileScope() {
  const std::int64_t spent = threadTimeNs() - cpu_begin_ns_;
  innermost = around_;
  if (around_ != nullptr) around_->cpu_inside_ns_ += spent;
  busy_ns[static_cast<std::size_t>(activity_)].fetch_add(spent - cpu_inside_ns_, std::memory_order_relaxed);
  if (trace_ != nullptr) trace_->add({activity_, begin_ns_, trace_->nowNs(), spent}, notes_);
}

void ProfileScope::note(std::string_view key, std::uint64_t value) { notes_ += fmt::format(R"(,"{}":{})", key, value); }

void ProfileScope::note(std::string_view key, std::string_view value) {
  notes_ += fmt::format(R"(,"{}":")", key);
  for (const char c : utf8OfName(value)) {
    if (c == '"' || c == '\\') notes_ += '\\';
    if (c >= 0 && c < 0x20)
      notes_ += fmt::format("\\u{:04x}", static_cast<unsigned>(c));
    else
      notes_ += c;
  }
  notes_ += '"';
}

}  // namespace kiln
