// Counts of spans and contents of a trace. Known because the test opens and closes the spans itself.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "base/error.h"
#include "base/file/file.h"
#include "base/thread/trace.h"
#include "support/system/expect_error.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

volatile double sink = 0;
void work() {
  for (int i = 0; i < 300000; ++i) sink = sink + i;
}

Json spansOf(const fs::path& path) {
  Json out = Json::array();
  const Json trace = Json::parse(readTextFile(path));
  for (const Json& event : trace["traceEvents"]) {
    if (event["ph"] == "X") out.push_back(event);
  }
  return out;
}

// Time inside a nested span counts for the nested span only, not for the span around it.
TEST(Spans, TimeInsideIsNotTheOutersOwn) {
  const fs::path path = freshDirectory("trace_nested") / "t.json";
  Trace trace(path);
  const BusyTimes before = BusyTimes::now();
  {
    const ProfileScope outer(Activity::kBrick);
    work();
    {
      ProfileScope inner(Activity::kTile);
      inner.note("splats", 7);
      inner.note("tile", "64,0");
      work();
    }
    const ProfileScope second(Activity::kCells);
    work();
  }
  const BusyTimes busy = BusyTimes::now().since(before);
  trace.finish();
  const Json spans = spansOf(path);
  ASSERT_EQ(spans.size(), 3u);  // in the order of their ends
  EXPECT_EQ(spans[0]["name"], "tile");
  EXPECT_EQ(spans[1]["name"], "cells");
  EXPECT_EQ(spans[2]["name"], "brick");
  EXPECT_EQ(spans[0]["args"]["splats"], 7);
  EXPECT_EQ(spans[0]["args"]["tile"], "64,0");
  const auto us = [&](std::size_t i) { return spans[i]["args"]["busy_us"].get<double>(); };
  constexpr double kRounding_us = 0.01;
  EXPECT_NEAR(1e6 * busy.of(Activity::kTile), us(0), kRounding_us);
  EXPECT_NEAR(1e6 * busy.of(Activity::kBrick), us(2) - us(0) - us(1), kRounding_us);
  EXPECT_GT(busy.of(Activity::kTile), 0);
  // Waiting for tiles is not busy time.
  EXPECT_NEAR(1e6 * busy.total(), us(0) + us(1), kRounding_us);
  for (const Json& span : spans) EXPECT_LE(spans[2]["ts"], span["ts"]);
}

TEST(Traces, EveryThreadHasATrackAndEverySpanIsThere) {
  const fs::path path = freshDirectory("trace_threads") / "t.json";
  constexpr int kThreads = 3, kSpans = 8000;
  Trace trace(path);
  std::vector<std::thread> threads;
  for (int i = 0; i < kThreads; ++i) {
    threads.emplace_back([i] {
      if (i == 0) Trace::nameThread("reads");
      for (int k = 0; k < kSpans; ++k) {
        ProfileScope span(Activity::kTile);
        span.note("k", static_cast<std::uint64_t>(k));
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  // Spans are written to a temporary file during the run, so memory stays bounded.
  const fs::path temporary = fs::directory_iterator(path.parent_path())->path();
  EXPECT_NE(temporary, path);
  EXPECT_GT(fs::file_size(temporary), Trace::kMemoryBytes);
  trace.finish();
  EXPECT_FALSE(fs::exists(temporary));
  const Json events = Json::parse(readTextFile(path))["traceEvents"];
  std::map<int, int> spans;
  std::set<std::string> names;
  for (const Json& event : events) {
    if (event["name"] == "thread_name") names.insert(event["args"]["name"].get<std::string>().substr(0, 5));
    if (event["ph"] != "X") continue;
    EXPECT_EQ(event["args"]["k"], spans[event["tid"].get<int>()]++);
  }
  EXPECT_EQ(spans.size(), std::size_t{kThreads});
  for (const auto& [track, count] : spans) EXPECT_EQ(count, kSpans) << track;
  EXPECT_EQ(names, (std::set<std::string>{"draws", "reads"}));
}

TEST(Traces, UnfinishedOnesLeaveNothing) {
  const fs::path directory = freshDirectory("trace_unfinished");
  {
    const Trace trace(directory / "t.json");
    const ProfileScope span(Activity::kTile);
    EXPECT_TRUE(span.traced());
  }
  EXPECT_TRUE(fs::is_empty(directory));
  const ProfileScope span(Activity::kTile);
  EXPECT_FALSE(span.traced());
}

TEST(Traces, AFullDiskIsSaidAtTheEnd) {
  EXPECT_THROW(Trace(freshDirectory("trace_nowhere") / "none" / "t.json"), Error);
  const fs::path path = freshDirectory("trace_full") / "t.json";
  fs::create_symlink("/dev/full", path);
  expectError([&] { Trace trace(path); }, ErrorCode::kNoSpace, "");
  EXPECT_EQ(Trace::active(), nullptr);
}

}  // namespace
}  // namespace kiln::test
