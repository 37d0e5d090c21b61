// A server with a service of the test's own, on a thread.
#pragma once

#include <atomic>
#include <chrono>
#include <string>
#include <thread>
#include <vector>

#include "base/error.h"
#include "support/system/http_client.h"
#include "view/view_server.h"

namespace kiln::test {

/// "session" and "large" are read; "echo" answers its body; "stream" sends records until the client leaves.
class TestService : public ViewService {
 public:
  Request kindOf(std::string_view name) const override {
    return name == "session" || name == "large" ? Request::kReads
           : name == "echo" || name == "stream" ? Request::kPosts
                                                : Request::kUnknown;
  }
  void answer(std::string_view name, const std::string& body, ViewClient& client) override {
    ++answers;
    if (name == "stream") return stream(client);
    if (name == "large") return client.document("application/octet-stream", std::vector<std::byte>(kLargeBytes));
    if (body == "fail") throw Error(ErrorCode::kUsage, "a \"wrong\" request");
    const std::string text = name == "echo" ? body : R"({"title": "test"})";
    client.document("application/json", std::as_bytes(std::span(text)));
  }
  void stop() override { stopped = true; }

  /// More than the system's buffers of a connection hold.
  static constexpr std::size_t kLargeBytes = 32 << 20;

  std::atomic<int> answers = 0, streams_ended = 0;
  std::atomic<bool> stopped = false;

 private:
  void stream(ViewClient& client) {
    const std::string payload(1000, 'x');
    try {
      while (!client.gone() && !stopped) {
        client.record(R"({"kind": "picture"})", std::as_bytes(std::span(payload)));
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      }
    } catch (const Error&) {
    }
    ++streams_ended;
  }
};

class TestServer {
 public:
  explicit TestServer(const ViewServerOptions& options)
      : server_(makeViewServer(service, options)), thread_([this] { server_->run([this] { return over_.load(); }); }) {}
  ~TestServer() { end(); }
  void end() {
    over_ = true;
    if (thread_.joinable()) thread_.join();
  }
  std::uint16_t port() const { return server_->port(); }
  const ViewServer& server() const { return *server_; }

  /// "GET /TARGET HTTP/1.1" with the right Host and further lines.
  std::string request(const std::string& verb_and_target, const std::string& lines = "") const {
    return verb_and_target + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port()) + "\r\nConnection: close\r\n" +
           lines + "\r\n";
  }
  std::string token() const { return "Authorization: Bearer " + server_->token() + "\r\n"; }
  std::string post(const std::string& name, const std::string& body, const std::string& lines = "") const {
    return request("POST /api/" + name, token() + "Content-Type: application/json\r\nContent-Length: " +
                                            std::to_string(body.size()) + "\r\n" + lines) +
           body;
  }
  std::string answerTo(const std::string& bytes) const {
    HttpClient client(port());
    client.send(bytes);
    return client.receive();
  }

  TestService service;

 private:
  std::unique_ptr<ViewServer> server_;
  std::atomic<bool> over_ = false;
  std::thread thread_;
};

}  // namespace kiln::test
