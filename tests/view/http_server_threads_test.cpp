// Known: threads of connections share the service and the list of connections alone, so that no requests, refusals or
// ends at the same time race.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "view/drawing_turns.h"
#include "view/test_server.h"

namespace kiln::test {
namespace {

TEST(HttpServerThreads, Requests_fromManyClients) {
  TestServer server({.header_s = 1, .request_s = 1, .connections = 4});
  std::atomic<int> served = 0, refused = 0;
  std::vector<std::thread> clients;
  for (int i = 0; i < 6; ++i) {
    clients.emplace_back([&, i] {
      for (int k = 0; k < 20; ++k) {
        if (i == 0) {
          HttpClient stream(server.port());
          stream.send(server.post("stream", "{}"));
          stream.receiveUntil("picture", 1);
          continue;
        }
        const int status = statusOf(server.answerTo(server.post("echo", "{}")));
        ++(status == 200 ? served : refused);
      }
    });
  }
  for (std::thread& client : clients) client.join();
  EXPECT_EQ(served + refused, 100);
  EXPECT_GT(served, 0);
  server.end();
}

// A single thread draws at a time; a frame goes before other work.
TEST(DrawingTurnsThreads, OneAtATime_framesFirst) {
  DrawingTurns turns;
  DrawingTurns::Page pages[6], page, other;
  std::atomic<int> drawing = 0, most = 0, given = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 6; ++i) {
    threads.emplace_back([&, i] {
      for (int k = 0; k < 50; ++k) {
        const DrawingTurns::Turn turn(turns, i % 2 == 0 ? turns.arrive(pages[i]) : DrawingTurns::kOther,
                                      [] { return false; });
        if (!turn.given()) continue;
        ++given;
        const int now = ++drawing;
        most = std::max(most.load(), now);
        --drawing;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(given, 300);
  EXPECT_EQ(most, 1);
  EXPECT_FALSE(turns.newerWaits(DrawingTurns::kOther));
  const std::uint64_t older = turns.arrive(page), newer = turns.arrive(page), others = turns.arrive(other);
  EXPECT_TRUE(page.superseded(older));
  EXPECT_FALSE(page.superseded(newer));
  EXPECT_FALSE(other.superseded(others));
  const DrawingTurns::Turn held(turns, newer, [] { return false; });
  EXPECT_FALSE(turns.newerWaits(newer));
  bool waited = false;
  const DrawingTurns::Turn late(turns, others, [&] { return waited = turns.newerWaits(newer); });
  EXPECT_FALSE(late.given());
  EXPECT_TRUE(waited);
  EXPECT_FALSE(turns.newerWaits(newer));
  const DrawingTurns::Turn urgent(turns, DrawingTurns::kUrgent, [&] { return waited = turns.newerWaits(newer); });
  EXPECT_FALSE(urgent.given());
}

}  // namespace
}  // namespace kiln::test
