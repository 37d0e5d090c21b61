// Known: RFC 9112's messages, and the rules of view_server.h: what has no token, or comes from elsewhere, is refused
// within a second, and the server lives on.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <random>
#include <set>

#include "base/error.h"
#include "support/system/expect_error.h"
#include "support/system/sanitized.h"
#include "support/volumes/test_store.h"
#include "view/test_server.h"

namespace kiln::test {
namespace {
namespace fs = std::filesystem;

double secondsOf(const std::function<void()>& call) {
  const auto begin = std::chrono::steady_clock::now();
  call();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

class HttpServerTest : public ::testing::Test {
 protected:
  HttpServerTest() : server_({.header_s = 0.4, .request_s = 0.6}) {}
  // Connections of the test may be ending.
  void TearDown() override {
    int status = 0;
    for (int i = 0; i < 100 && status != 200; ++i) {
      status = statusOf(session());
      if (status != 200) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_EQ(status, 200) << "the server is not alive";
  }

  std::string session() const { return server_.answerTo(server_.request("GET /api/session", server_.token())); }
  int status(const std::string& bytes) const {
    int out = 0;
    EXPECT_LT(secondsOf([&] { out = statusOf(server_.answerTo(bytes)); }), 1.0) << bytes.substr(0, 200);
    return out;
  }

  TestServer server_;
};

TEST_F(HttpServerTest, FilesAndRequests_areAnswered) {
  const std::string page = server_.answerTo(server_.request("GET /"));
  EXPECT_EQ(statusOf(page), 200);
  for (const char* header :
       {"Content-Security-Policy: default-src 'none'; script-src 'self'", "X-Content-Type-Options: nosniff",
        "Referrer-Policy: no-referrer", "X-Frame-Options: DENY", "Content-Type: text/html", "Cache-Control: no-store"})
    EXPECT_NE(page.find(header), std::string::npos) << header;
  EXPECT_EQ(page.find("Access-Control"), std::string::npos);
  EXPECT_NE(page.find("<html"), std::string::npos);
  EXPECT_EQ(status(server_.request("GET /index.html?x")), 200);
  EXPECT_NE(session().find(R"({"title": "test"})"), std::string::npos);
  EXPECT_NE(server_.answerTo(server_.post("echo", R"({"a": 1})")).find(R"({"a": 1})"), std::string::npos);
  const std::string failed = server_.answerTo(server_.post("echo", "fail"));
  EXPECT_EQ(statusOf(failed), 400);
  EXPECT_NE(failed.find(R"({"error": "a \"wrong\" request"})"), std::string::npos) << failed;
}

// RFC 9110, 9.3.2: the header of GET without a body, or the next answer on the connection would begin with the body.
TEST_F(HttpServerTest, Head_hasNoBody) {
  const std::string page = server_.answerTo(server_.request("GET /"));
  const std::size_t body = page.find("\r\n\r\n") + 4;
  EXPECT_EQ(server_.answerTo(server_.request("HEAD /")), page.substr(0, body));
  const std::pair<std::string, int> cases[] = {{server_.request("HEAD /none.js"), 404},
                                               {server_.request("HEAD /api/session"), 401},
                                               {server_.request("HEAD /api/session", server_.token()), 405}};
  for (const auto& [request, expected] : cases) {
    const std::string answer = server_.answerTo(request);
    EXPECT_EQ(statusOf(answer), expected);
    EXPECT_TRUE(answer.ends_with("\r\n\r\n")) << answer;
  }
}

TEST_F(HttpServerTest, WhatHasNoToken_orComesFromElsewhere_isRefused) {
  const std::string port = std::to_string(server_.port()), token = server_.token();
  const std::string good = server_.server().token();
  EXPECT_EQ(good.size(), 32u);
  EXPECT_EQ(status(server_.request("GET /api/session")), 401);
  for (const std::string& wrong :
       {std::string(32, '0'), std::string(), good + "0", good.substr(1), std::string(4000, 'a')})
    EXPECT_EQ(status(server_.request("GET /api/session", "Authorization: Bearer " + wrong + "\r\n")), 401) << wrong;
  EXPECT_EQ(status(server_.request("GET /api/session", "Authorization: Basic " + good + "\r\n")), 401);
  EXPECT_EQ(status(server_.request("GET /api/session?token=" + good)), 401);
  EXPECT_EQ(status(server_.request("GET /api/session", token + token)), 401) << "two tokens";
  const auto with_host = [&](const std::string& host, const std::string& lines = "") {
    return "GET /api/session HTTP/1.1\r\n" + host + token + lines + "Connection: close\r\n\r\n";
  };
  for (const std::string& host : std::vector<std::string>{
           "Host: evil.example:" + port + "\r\n", "Host: evil.example\r\n", "", "Host: 127.0.0.1.evil.example\r\n",
           "Host: localhost.evil.example:" + port + "\r\n", "Host: 127.0.0.1:" + port + "\r\nHost: evil.example\r\n",
           "Host: [::1\r\n", "Host: \r\n", "Host: [::1].evil.example\r\n", "Host: localhost:80@evil.example\r\n",
           "Host: 127.0.0.1:abc\r\n"})
    EXPECT_EQ(status(with_host(host)), 403) << host;
  for (const std::string& host : {"Host: localhost:" + port + "\r\n", std::string("Host: [::1]:8000\r\n")})
    EXPECT_EQ(status(with_host(host)), 200) << host;
  const std::string own = "Host: 127.0.0.1:" + port + "\r\n";
  EXPECT_EQ(status(with_host(own, "Origin: http://127.0.0.1:" + port + "\r\n")), 200);
  for (const char* origin : {"http://evil.example", "null", "http://127.0.0.1:1", "http://localhost", "file://", ""})
    EXPECT_EQ(status(with_host(own, std::string("Origin: ") + origin + "\r\n")), 403) << origin;
  // A page of another origin, too.
  EXPECT_EQ(status("GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n"), 403);
}

TEST_F(HttpServerTest, WrongRequests_areRefused) {
  const std::string token = server_.token();
  const auto post = [&](const std::string& type) {
    return server_.request("POST /api/echo", token + type + "Content-Length: 2\r\n") + "{}";
  };
  EXPECT_EQ(status(post("Content-Type: application/json; charset=utf-8\r\n")), 200);
  for (const char* type : {"Content-Type: text/plain\r\n", "", "Content-Type: application/x-www-form-urlencoded\r\n",
                           "Content-Type: text/plain; application/json\r\n", "Content-Type: application/jsonx\r\n"})
    EXPECT_EQ(status(post(type)), 415) << type;
  EXPECT_EQ(status(server_.request("GET /api/echo", token)), 405);
  EXPECT_EQ(status(server_.request("POST /api/session", token + "Content-Length: 0\r\n")), 405);
  EXPECT_EQ(status(server_.request("OPTIONS /api/echo", token)), 405);
  EXPECT_EQ(status(server_.request("PUT /", "")), 405);
  EXPECT_EQ(status(server_.request("GET /api/none", token)), 404);
  for (const char* path : {"/none.js", "/../../etc/passwd", "/%2e%2e/", "//etc/passwd", "/index.html/"})
    EXPECT_EQ(status(server_.request(std::string("GET ") + path)), 404) << path;
  EXPECT_EQ(status("nonsense\r\n\r\n"), 400);
  EXPECT_EQ(status(server_.request("GET /", "X: " + std::string(9000, 'x') + "\r\n")), 431);
}

TEST_F(HttpServerTest, LargeBodies_areRefused) {
  const std::string large(2 << 20, 'x');
  EXPECT_EQ(status(server_.post("echo", large)), 413);
  const std::string head = server_.request(
      "POST /api/echo", server_.token() + "Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n");
  EXPECT_EQ(status(head + "200000\r\n" + large + "\r\n0\r\n\r\n"), 413);
  // Lines behind the last chunk.
  EXPECT_EQ(status(head + "1\r\nx\r\n0\r\nX: " + std::string(3 << 20, 'x') + "\r\n\r\n"), 413);
  EXPECT_EQ(status(server_.post("echo", std::string(1 << 20, 'x'))), 200);
  EXPECT_EQ(server_.service.answers, 1);
}

TEST_F(HttpServerTest, HalfARequest_endsInTime) {
  HttpClient header(server_.port()), body(server_.port()), silent(server_.port());
  header.send("GET / HTTP/1.1\r\nHo");
  const std::string whole = server_.post("echo", "0123456789");
  body.send(whole.substr(0, whole.size() - 5));
  EXPECT_LT(secondsOf([&] { EXPECT_EQ(statusOf(header.receive()), 408); }), 1.5);
  EXPECT_LT(secondsOf([&] { EXPECT_EQ(statusOf(body.receive()), 408); }), 1.5);
  EXPECT_LT(secondsOf([&] { silent.receive(); }), 1.5);
  // A byte now and then does not lengthen the time.
  HttpClient slow(server_.port());
  const std::string drip = "GET / HTTP/1.1\r\nX: yyyyyyyyyyyyyyyyyyyyyyyyyyyy";
  std::string answer;
  const double seconds = secondsOf([&] {
    for (std::size_t i = 0; i < drip.size() && answer.empty(); ++i) {
      slow.send(drip.substr(i, 1));
      answer = slow.receive(0.05);
    }
  });
  EXPECT_EQ(statusOf(answer), 408);
  EXPECT_LT(seconds, 1.5);
}

// The reader pauses for shorter times than the limit of 0.6 s, and takes several such limits in all.
TEST_F(HttpServerTest, SlowReader_getsTheWholeAnswer) {
  HttpClient client(server_.port());
  client.send(server_.request("GET /api/large", server_.token()));
  std::size_t bytes = 0;
  for (int i = 0; i < 8; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    bytes += client.receiveBytes(TestService::kLargeBytes / 8).size();
  }
  bytes += client.receive().size();
  EXPECT_GT(bytes, TestService::kLargeBytes);
}

TEST_F(HttpServerTest, ReaderThatStops_losesTheAnswer) {
  HttpClient client(server_.port());
  client.send(server_.request("GET /api/large", server_.token()));
  client.receiveBytes(1000);
  std::this_thread::sleep_for(std::chrono::milliseconds(1200));
  EXPECT_LT(client.receive().size(), TestService::kLargeBytes - 1000);
}

TEST_F(HttpServerTest, TwentyConnections_eightAreServed) {
  std::vector<std::unique_ptr<HttpClient>> clients;
  for (int i = 0; i < 20; ++i) {
    clients.push_back(std::make_unique<HttpClient>(server_.port()));
    clients.back()->send("GET / HTTP/1.1\r\n");
  }
  std::multiset<int> codes;
  const double seconds = secondsOf([&] {
    for (const auto& client : clients) codes.insert(statusOf(client->receive()));
  });
  EXPECT_EQ(codes.count(503), 12u);
  EXPECT_EQ(codes.count(408), 8u);
  EXPECT_LT(seconds, 2.0);
}

// Connections that wait for their next request make room.
TEST_F(HttpServerTest, IdleConnections_giveWay) {
  std::string request = server_.request("GET /");
  request.erase(request.find("Connection: close\r\n"), 19);
  std::vector<std::unique_ptr<HttpClient>> clients;
  for (int i = 0; i < 12; ++i) {
    clients.push_back(std::make_unique<HttpClient>(server_.port()));
    clients.back()->send(request);
    EXPECT_EQ(statusOf(clients.back()->receiveUntil("</html>")), 200) << i;
  }
  // The last one is kept, and serves again.
  clients.back()->send(request);
  EXPECT_EQ(statusOf(clients.back()->receiveUntil("</html>")), 200);
}

TEST_F(HttpServerTest, AStream_endsWithItsClient) {
  HttpClient client(server_.port());
  client.send(server_.post("stream", "{}"));
  const std::string begin = client.receiveUntil(R"({"kind": "picture"})");
  EXPECT_NE(begin.find("Transfer-Encoding: chunked"), std::string::npos);
  // A chunk of 4 + 19 + 4 + 1000 bytes, with lengths of little-endian order.
  EXPECT_NE(begin.find(std::string("\r\n403\r\n\x13\0\0\0{\"kind\"", 18)), std::string::npos);
  client.close();
  const double seconds = secondsOf([&] {
    while (server_.service.streams_ended == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  EXPECT_LT(seconds, 0.5);
}

TEST_F(HttpServerTest, TheEnd_endsStreams) {
  HttpClient client(server_.port());
  client.send(server_.post("stream", "{}"));
  client.receiveUntil("picture");
  TestServer other({});
  HttpClient of_other(other.port());
  of_other.send(other.post("stream", "{}"));
  of_other.receiveUntil("picture");
  EXPECT_LT(secondsOf([&] { other.end(); }), 1.0);
  EXPECT_EQ(other.service.streams_ended, 1);
}

TEST_F(HttpServerTest, MutatedRequests_neverEndTheServer) {
  std::mt19937 random(20240917);
  const auto below = [&](std::size_t most) { return std::uniform_int_distribution<std::size_t>(0, most - 1)(random); };
  const std::vector<std::string> seeds = {
      server_.post("echo", R"({"size": [64, 64], "job": {"kiln": 2}})"),
      server_.request("GET /api/session", server_.token()), server_.request("GET /index.html"),
      server_.request("POST /api/echo",
                      server_.token() + "Content-Type: application/json\r\nTransfer-Encoding: chunked\r\n") +
          "5\r\nhello\r\n0\r\n\r\n"};
  const int cases = casesOf(10000, 600);
  for (int i = 0; i < cases; ++i) {
    std::string bytes = seeds[below(seeds.size())];
    for (std::size_t change = 0; change <= below(8); ++change) {
      const std::size_t at = below(bytes.size());
      switch (below(4)) {
        case 0:
          bytes[at] = static_cast<char>(below(256));
          break;
        case 1:
          bytes.erase(at, 1 + below(6));
          break;
        case 2:
          bytes.insert(at, std::string(1 + below(4), static_cast<char>(below(256))));
          break;
        default:
          bytes.insert(at, bytes.substr(below(bytes.size()), below(40)));
      }
      if (bytes.empty()) bytes = "x";
    }
    HttpClient client(server_.port());
    client.send(bytes);
    // A request that waits for more bytes is left alone.
    const std::string answer = client.receive(0.002);
    if (!answer.empty()) {
      ASSERT_NE(statusOf(answer), 0) << "seed 20240917, case " << i;
    }
  }
}

TEST(HttpServer, ANameOfAProxy_isAllowed) {
  TestServer server({.hosts = {"hub.example"}});
  const auto with = [&](const std::string& lines) {
    return statusOf(
        server.answerTo("GET /api/session HTTP/1.1\r\nConnection: close\r\n" + server.token() + lines + "\r\n"));
  };
  EXPECT_EQ(with("Host: hub.example\r\nOrigin: https://hub.example\r\n"), 200);
  EXPECT_EQ(with("Host: 127.0.0.1:8888\r\nOrigin: https://hub.example\r\n"), 200);
  EXPECT_EQ(with("Host: hub.example.evil\r\n"), 403);
  EXPECT_EQ(with("Host: hub.example\r\nOrigin: https://evil.example\r\n"), 403);
}

TEST(HttpServer, ASocket_isItsOwnersAlone) {
  // The name of a socket has at most 107 bytes, which the folder of the tests may exceed.
  std::string folder = (fs::temp_directory_path() / "kiln_view_XXXXXX").string();
  ASSERT_NE(::mkdtemp(folder.data()), nullptr);
  const fs::path path = fs::path(folder) / "s";
  {
    TestServer server({.socket = path});
    struct stat made {};
    ASSERT_EQ(::lstat(path.c_str(), &made), 0);
    EXPECT_TRUE(S_ISSOCK(made.st_mode));
    EXPECT_EQ(made.st_mode & 0777, 0600u);
    HttpClient client(path.string());
    client.send("GET /api/session HTTP/1.1\r\nHost: localhost:8000\r\nConnection: close\r\n" + server.token() + "\r\n");
    EXPECT_EQ(statusOf(client.receive()), 200);
    TestService service;
    expectError([&] { makeViewServer(service, {.socket = path}); }, ErrorCode::kExists, "running");
  }
  EXPECT_FALSE(fs::exists(fs::symlink_status(path))) << "the socket is left behind";
  writeText(path, "a file");
  TestService service;
  expectError([&] { makeViewServer(service, {.socket = path}); }, ErrorCode::kExists, "is a file already");
  expectError([&] { makeViewServer(service, {.socket = fs::path(std::string(200, 'x'))}); }, ErrorCode::kUsage,
              "longer");
  fs::remove_all(folder);
  TestServer taken({});
  expectError([&] { makeViewServer(service, {.port = taken.port()}); }, ErrorCode::kIo, "--port");
}

}  // namespace
}  // namespace kiln::test
