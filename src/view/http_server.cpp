// The module libkiln_view: HTTP by Boost.Beast, blocking, one thread for each connection.
// Method. Beast parses headers and bodies; view/http_stream.h reads and writes, view/request_rules.h judges headers.
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/buffer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <cerrno>
#include <chrono>
#include <list>
#include <mutex>
#include <optional>
#include <thread>

#include "base/error.h"
#include "base/text.h"
#include "view/http_stream.h"
#include "view/page_files.h"
#include "view/request_rules.h"
#include "view/view_server.h"

namespace kiln {
namespace {

namespace http = boost::beast::http;
namespace net = boost::asio;
namespace fs = std::filesystem;
using boost::system::error_code;
using Request = http::request<http::string_body>;
using Status = http::status;

constexpr std::uint32_t kMostHeaderBytes = 8 << 10;
constexpr std::uint64_t kMostBodyBytes = 1 << 20;
// Most bytes of a request as sent: Beast limits neither the lengths nor the trailer of chunks.
constexpr std::uint64_t kMostRequestBytes = kMostHeaderBytes + 2 * kMostBodyBytes;
// Time for which a connection without a request is kept. unit: seconds.
constexpr double kIdleSeconds = 60;
constexpr int kBacklog = 64;
constexpr int kPollEvery_ms = 100;
constexpr std::string_view kServer = "kiln";
constexpr std::string_view kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors ";
// Pages that may show the page in a frame.
constexpr std::string_view kNobody = "'none'", kThisMachine = "http://127.0.0.1:* http://localhost:*";

std::string_view viewOf(boost::beast::string_view text) { return {text.data(), text.size()}; }

std::string_view typeOf(std::string_view name) {
  const std::size_t dot = name.rfind('.');
  const std::string_view ending = dot == std::string_view::npos ? "" : name.substr(dot + 1);
  if (ending == "html") return "text/html; charset=utf-8";
  if (ending == "js") return "text/javascript; charset=utf-8";
  if (ending == "css") return "text/css; charset=utf-8";
  if (ending == "svg") return "image/svg+xml";
  if (ending == "json") return "application/json";
  return "application/octet-stream";
}

std::string jsonError(std::string_view sentence) {
  std::string out = "{\"error\": \"";
  for (const char c : utf8Of(shown(sentence))) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + "\"}";
}

// A refusal before the session is asked.
struct Refusal {
  Status status;
  std::string sentence;
};

Status statusOf(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUsage:
    case ErrorCode::kFormat:
    case ErrorCode::kUnsupported:
    case ErrorCode::kBudget:
      return Status::bad_request;
    case ErrorCode::kNotFound:
      return Status::not_found;
    case ErrorCode::kCancelled:
      return Status::service_unavailable;
    default:
      return Status::internal_server_error;
  }
}

class Client final : public ViewClient {
 public:
  /// `head_only` leaves out the body of a whole answer, as HEAD asks.
  Client(HttpStream& stream, bool keep_alive, double seconds, bool framed, bool head_only)
      : stream_(stream), keep_alive_(keep_alive), seconds_(seconds), framed_(framed), head_only_(head_only) {}

  void document(std::string_view type, std::span<const std::byte> bytes) override { whole(Status::ok, type, bytes); }
  void record(std::string_view json, std::span<const std::byte> payload) override {
    if (!begun_) {
      http::response<http::empty_body> head(Status::ok, 11);
      fill(head, "application/octet-stream");
      head.chunked(true);
      // Proxies pass each record on at once.
      head.set("X-Accel-Buffering", "no");
      sendHead(head);
      streams_ = true;
    }
    const auto four = [](std::size_t count) {
      std::array<char, 4> out;
      for (std::size_t i = 0; i < 4; ++i) out[i] = static_cast<char>(count >> (8 * i) & 255);
      return out;
    };
    const auto json_bytes = four(json.size()), payload_bytes = four(payload.size());
    const std::array<net::const_buffer, 4> parts{net::buffer(json_bytes), net::buffer(json.data(), json.size()),
                                                 net::buffer(payload_bytes),
                                                 net::buffer(payload.data(), payload.size())};
    send(http::make_chunk(parts));
  }
  bool gone() const override { return failed_ || stream_.closed(); }

  bool begun() const { return begun_; }
  bool failed() const { return failed_; }
  void whole(Status status, std::string_view type, std::span<const std::byte> bytes) {
    http::response<http::empty_body> head(status, 11);
    fill(head, type);
    head.content_length(bytes.size());
    sendHead(head);
    if (!head_only_) send(net::buffer(bytes.data(), bytes.size()));
  }
  void error(Status status, std::string_view sentence) {
    const std::string text = jsonError(sentence);
    whole(status, "application/json", std::as_bytes(std::span(text)));
  }
  void finish() {
    if (streams_) send(http::make_chunk_last());
  }

 private:
  void fill(http::response<http::empty_body>& head, std::string_view type) const {
    const auto text = [](std::string_view value) { return boost::beast::string_view(value.data(), value.size()); };
    head.set(http::field::server, text(kServer));
    head.set(http::field::content_type, text(type));
    head.set(http::field::cache_control, "no-store");
    head.set("Content-Security-Policy", text(std::string(kPolicy).append(framed_ ? kThisMachine : kNobody)));
    head.set("X-Content-Type-Options", "nosniff");
    if (!framed_) head.set("X-Frame-Options", "DENY");
    head.set("Referrer-Policy", "no-referrer");
    head.set("Cross-Origin-Resource-Policy", "same-origin");
    head.set("Cross-Origin-Opener-Policy", "same-origin");
    head.keep_alive(keep_alive_);
  }
  void sendHead(http::response<http::empty_body>& head) {
    begun_ = true;
    stream_.withinOfProgress(seconds_);
    http::response_serializer<http::empty_body> serializer(head);
    error_code error;
    http::write_header(stream_, serializer, error);
    require(error);
  }
  template <class Buffers>
  void send(const Buffers& buffers) {
    stream_.withinOfProgress(seconds_);
    error_code error;
    net::write(stream_, buffers, error);
    require(error);
  }
  void require(const error_code& error) {
    if (!error) return;
    failed_ = true;
    throw Error(ErrorCode::kCancelled, "nobody reads the answer");
  }

  HttpStream& stream_;
  const bool keep_alive_;
  const double seconds_;
  const bool framed_, head_only_;
  bool begun_ = false, streams_ = false;
  std::atomic<bool> failed_ = false;
};

class HttpServer final : public ViewServer {
 public:
  HttpServer(ViewService& service, const ViewServerOptions& options)
      : service_(service), options_(options), token_(randomToken()) {
    if (options_.socket.empty())
      listenOnPort();
    else
      listenOnSocket();
  }
  ~HttpServer() override {
    endAll();
    if (socket_inode_ == 0) return;
    struct stat now {};
    // Another server may have taken the name.
    if (::lstat(options_.socket.c_str(), &now) == 0 && now.st_ino == socket_inode_) ::unlink(options_.socket.c_str());
  }

  std::string address() const override {
    return options_.socket.empty() ? "http://127.0.0.1:" + std::to_string(port_) + "/#" + token_
                                   : "http://localhost/#" + token_;
  }
  std::uint16_t port() const override { return port_; }
  const std::string& token() const override { return token_; }

  void run(const std::function<bool()>& stopped) override {
    while (!stopped()) {
      pollfd one{listener_.get(), POLLIN, 0};
      if (::poll(&one, 1, kPollEvery_ms) > 0)
        take(SocketFile(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC)));
      reap();
    }
    endAll();
  }

 private:
  struct Connection {
    explicit Connection(SocketFile&& given) : file(std::move(given)) {}
    SocketFile file;
    std::thread thread;
    std::atomic<bool> idle = false;  // between two requests
    std::atomic<bool> done = false;
  };

  void listenOnPort() {
    listener_ = SocketFile(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (!listener_) throw systemError(errno, {}, "making a socket");
    const int on = 1;
    ::setsockopt(listener_.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
    sockaddr_in place{};
    place.sin_family = AF_INET;
    place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    place.sin_port = htons(options_.port);
    if (::bind(listener_.get(), reinterpret_cast<const sockaddr*>(&place), sizeof place) != 0)
      throw systemError(errno, {}, "--port: listening on 127.0.0.1:" + std::to_string(options_.port));
    listen();
    socklen_t size = sizeof place;
    if (::getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&place), &size) != 0)
      throw systemError(errno, {}, "asking for the port");
    port_ = ntohs(place.sin_port);
  }

  void listenOnSocket() {
    sockaddr_un place{};
    place.sun_family = AF_UNIX;
    const std::string path = options_.socket.string();
    if (path.size() >= sizeof place.sun_path)
      throw Error(ErrorCode::kUsage, options_.socket, "--socket",
                  "is longer than " + std::to_string(sizeof place.sun_path - 1) + " bytes; choose a shorter path");
    std::copy(path.begin(), path.end(), place.sun_path);
    const auto* const address = reinterpret_cast<const sockaddr*>(&place);
    removeLeftSocket(address, sizeof place);
    listener_ = SocketFile(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (!listener_) throw systemError(errno, options_.socket, "making a socket");
    const mode_t before = ::umask(0177);
    const int bound = ::bind(listener_.get(), address, sizeof place), why = errno;
    ::umask(before);
    if (bound != 0) throw systemError(why, options_.socket, "--socket: listening");
    if (::chmod(path.c_str(), 0600) != 0) throw systemError(errno, options_.socket, "closing it to other users");
    struct stat made {};
    if (::lstat(path.c_str(), &made) == 0) socket_inode_ = made.st_ino;
    listen();
  }

  // Removes the socket of a server that was killed. throws: Error kExists for another file, or a running server.
  void removeLeftSocket(const sockaddr* address, socklen_t size) const {
    struct stat there {};
    if (::lstat(options_.socket.c_str(), &there) != 0) return;
    if (!S_ISSOCK(there.st_mode))
      throw Error(ErrorCode::kExists, options_.socket, "--socket", "is a file already; choose another path");
    const SocketFile probe(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    if (::connect(probe.get(), address, size) == 0 || errno != ECONNREFUSED)
      throw Error(ErrorCode::kExists, options_.socket, "--socket",
                  "is the socket of a running program; choose another path");
    if (::unlink(options_.socket.c_str()) != 0) throw systemError(errno, options_.socket, "removing an old socket");
  }

  void listen() const {
    if (::listen(listener_.get(), kBacklog) != 0) throw systemError(errno, options_.socket, "listening");
  }

  void take(SocketFile file) {
    if (!file) {
      // Without a free file descriptor poll would return at once, again and again.
      reap();
      if (!closeIdle()) std::this_thread::sleep_for(std::chrono::milliseconds(kPollEvery_ms));
      return;
    }
    const int on = 1;
    if (options_.socket.empty()) ::setsockopt(file.get(), IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    reap();
    if (static_cast<int>(connections_.size()) >= options_.connections && !closeIdle()) return refuse(file);
    Connection& connection = connections_.emplace_back(std::move(file));
    try {
      connection.thread = std::thread([this, &connection] { serve(connection); });
    } catch (const std::system_error&) {
      refuse(connection.file);
      connections_.pop_back();
    }
  }

  // Answers in one piece without a thread.
  static void refuse(const SocketFile& file) {
    static const std::string kBody = jsonError("too many connections at a time; close another page of this server");
    static const std::string kBusy =
        "HTTP/1.1 503 Service Unavailable\r\nServer: kiln\r\nContent-Type: application/json\r\nConnection: close\r\n"
        "Content-Length: " +
        std::to_string(kBody.size()) + "\r\n\r\n" + kBody;
    ::send(file.get(), kBusy.data(), kBusy.size(), MSG_DONTWAIT | MSG_NOSIGNAL);
    ::shutdown(file.get(), SHUT_WR);
    // Bytes that have arrived are taken, or the answer would be lost.
    std::array<char, 4096> rest;
    for (int i = 0; i < 16 && ::recv(file.get(), rest.data(), rest.size(), MSG_DONTWAIT) > 0; ++i) {
    }
  }

  // Closes a connection that waits for its next request. Returns false if there is none.
  bool closeIdle() {
    for (Connection& connection : connections_) {
      if (!connection.idle || connection.done) continue;
      ::shutdown(connection.file.get(), SHUT_RDWR);
      connection.thread.join();
      connections_.remove_if([&](const Connection& c) { return &c == &connection; });
      return true;
    }
    return false;
  }

  void reap() {
    for (auto connection = connections_.begin(); connection != connections_.end();) {
      if (!connection->done) {
        ++connection;
        continue;
      }
      connection->thread.join();
      connection = connections_.erase(connection);
    }
  }

  void endAll() {
    service_.stop();
    for (Connection& connection : connections_) ::shutdown(connection.file.get(), SHUT_RDWR);
    for (Connection& connection : connections_) connection.thread.join();
    connections_.clear();
  }

  // The thread of a connection.
  void serve(Connection& connection) noexcept {
    try {
      HttpStream stream(connection.file.get());
      boost::beast::flat_buffer buffer;
      bool first = true;
      for (bool more = true; more; first = false) {
        if (!first && buffer.size() == 0) {
          connection.idle = true;
          const bool asked = stream.waitsForRequest(kIdleSeconds);
          connection.idle = false;
          if (!asked) break;
        }
        more = serveOne(stream, buffer);
      }
      stream.end();
    } catch (...) {
      // The client is gone, or memory is short: the connection ends.
    }
    connection.done = true;
  }

  // Returns whether a further request may follow.
  bool serveOne(HttpStream& stream, boost::beast::flat_buffer& buffer) {
    http::request_parser<http::string_body> parser;
    parser.header_limit(kMostHeaderBytes);
    parser.body_limit(kMostBodyBytes);
    stream.within(options_.header_s);
    stream.allow(kMostRequestBytes);
    error_code error;
    http::read_header(stream, buffer, parser, error);
    const bool keeps = !error && parser.keep_alive();
    const bool head_only = parser.get().method() == http::verb::head;
    Client client(stream, keeps, options_.request_s, options_.framed, head_only);
    const auto refused = [&](const Refusal& refusal) {
      Client last(stream, false, options_.header_s, options_.framed, head_only);
      last.error(refusal.status, refusal.sentence);
      return false;
    };
    if (const auto refusal = refusalOf(error, stream)) return refusal->sentence.empty() ? false : refused(*refusal);
    if (const auto refusal = refusalOf(parser.get())) return refused(*refusal);
    stream.within(options_.request_s);
    if (viewOf(parser.get()[http::field::expect]) == "100-continue") {
      constexpr std::string_view kGoOn = "HTTP/1.1 100 Continue\r\n\r\n";
      net::write(stream, net::buffer(kGoOn.data(), kGoOn.size()), error);
    }
    if (!error && !parser.is_done()) http::read(stream, buffer, parser, error);
    if (const auto refusal = refusalOf(error, stream)) return refusal->sentence.empty() ? false : refused(*refusal);
    answer(parser.get(), client);
    return keeps && !client.failed();
  }

  // Returns a refusal for an error of reading. A refusal without a sentence is not sent.
  static std::optional<Refusal> refusalOf(const error_code& error, const HttpStream& stream) {
    if (!error) return std::nullopt;
    if (stream.late()) return Refusal{Status::request_timeout, "the request took too long; send it again"};
    if (error == http::error::body_limit)
      return Refusal{Status::payload_too_large, "the request is larger than 1 MiB; send a smaller one"};
    if (error == http::error::header_limit || error == http::error::buffer_overflow)
      return Refusal{Status::request_header_fields_too_large, "the header is larger than 8 KiB; send a smaller one"};
    if (error.category() == make_error_code(http::error::bad_method).category() &&
        error != http::error::end_of_stream && error != http::error::partial_message)
      return Refusal{Status::bad_request, "the request is no HTTP: " + error.message()};
    return Refusal{Status::bad_request, ""};
  }

  // Returns a refusal for a header.
  std::optional<Refusal> refusalOf(const Request& request) const {
    if (request.count(http::field::host) != 1 || !isOwnHost(viewOf(request[http::field::host]), options_.hosts))
      return Refusal{Status::forbidden,
                     "Host: is not this server's; open the address that kiln view printed, or give "
                     "--allow-host for a proxy"};
    if (request.count(http::field::origin) > 0 &&
        (request.count(http::field::origin) > 1 ||
         !isOwnOrigin(viewOf(request[http::field::origin]), viewOf(request[http::field::host]), options_.hosts)))
      return Refusal{Status::forbidden, "Origin: is another page's; open the address that kiln view printed"};
    const std::string_view target = viewOf(request.target());
    if (!target.starts_with('/')) return Refusal{Status::bad_request, "the target is no path; begin it with /"};
    if (!target.starts_with("/api/")) {
      if (request.method() != http::verb::get && request.method() != http::verb::head)
        return Refusal{Status::method_not_allowed, "a file is read by GET"};
      return std::nullopt;
    }
    if (request.count(http::field::authorization) != 1 ||
        !bearsToken(viewOf(request[http::field::authorization]), token_))
      return Refusal{Status::unauthorized, "the token is missing or wrong; open the address that kiln view printed"};
    const ViewService::Request kind = service_.kindOf(target.substr(5));
    if (kind == ViewService::Request::kUnknown) return Refusal{Status::not_found, "there is no such request"};
    if (request.method() != (kind == ViewService::Request::kPosts ? http::verb::post : http::verb::get))
      return Refusal{Status::method_not_allowed, kind == ViewService::Request::kPosts ? "use POST" : "use GET"};
    if (kind == ViewService::Request::kPosts) {
      const std::string type = lowered(viewOf(request[http::field::content_type]));
      if (type.substr(0, type.find_first_of("; ")) != "application/json")
        return Refusal{Status::unsupported_media_type, "Content-Type: expected application/json"};
    }
    return std::nullopt;
  }

  void answer(const Request& request, Client& client) {
    std::string_view target = viewOf(request.target());
    target.remove_prefix(1);
    try {
      if (target.starts_with("api/"))
        service_.answer(target.substr(4), request.body(), client);
      else
        file(target.substr(0, target.find('?')), client);
      client.finish();
    } catch (const Error& error) {
      if (client.failed()) return;
      if (client.begun()) throw;  // The answer cannot be ended well: the connection ends.
      client.error(statusOf(error.code()), error.what());
    } catch (const std::exception& error) {
      if (client.begun()) throw;
      client.error(Status::internal_server_error, error.what());
    }
  }

  static void file(std::string_view name, Client& client) {
    if (name.empty()) name = "index.html";
    for (const PageFile& file : pageFiles()) {
      if (file.name == name) return client.document(typeOf(name), file.bytes);
    }
    client.error(Status::not_found, "there is no such file");
  }

  ViewService& service_;
  const ViewServerOptions options_;
  const std::string token_;
  SocketFile listener_;
  std::uint16_t port_ = 0;
  ino_t socket_inode_ = 0;
  std::list<Connection> connections_;  // used by the accepting thread alone
};

}  // namespace
}  // namespace kiln

extern "C" [[gnu::visibility("default")]] kiln::ViewServer* kilnMakeViewServer(kiln::ViewService& service,
                                                                               const kiln::ViewServerOptions& options) {
  return new kiln::HttpServer(service, options);
}
