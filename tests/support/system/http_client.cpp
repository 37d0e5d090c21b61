#include "support/system/http_client.h"

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <stdexcept>

namespace kiln::test {
namespace {

int connected(int family, const sockaddr* address, socklen_t size) {
  const int file = ::socket(family, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (file < 0) throw std::runtime_error("no socket");
  if (::connect(file, address, size) == 0) return file;
  ::close(file);
  throw std::runtime_error("no connection");
}

}  // namespace

HttpClient::HttpClient(std::uint16_t port) {
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  place.sin_port = htons(port);
  file_ = connected(AF_INET, reinterpret_cast<const sockaddr*>(&place), sizeof place);
}

HttpClient::HttpClient(const std::string& socket_path) {
  sockaddr_un place{};
  place.sun_family = AF_UNIX;
  std::copy_n(socket_path.begin(), std::min(socket_path.size(), sizeof place.sun_path - 1), place.sun_path);
  file_ = connected(AF_UNIX, reinterpret_cast<const sockaddr*>(&place), sizeof place);
}

HttpClient::~HttpClient() { close(); }

void HttpClient::close() {
  if (file_ >= 0) ::close(file_);
  file_ = -1;
}

void HttpClient::send(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::send(file_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count <= 0) return;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
}

std::string HttpClient::receive(double seconds) { return receiveUntil({}, seconds); }

std::string HttpClient::receiveUntil(std::string_view mark, double seconds) {
  return received(seconds, [&](const std::string& out) {
    return mark.empty() || out.find(mark) == std::string::npos ? SIZE_MAX : 0;
  });
}

std::string HttpClient::receiveBytes(std::size_t count, double seconds) {
  return received(seconds, [&](const std::string& out) { return count - out.size(); });
}

std::string HttpClient::received(double seconds, const std::function<std::size_t(const std::string&)>& wanted) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  std::string out;
  std::array<char, 65536> some;
  while (const std::size_t most = std::min(some.size(), wanted(out))) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now()).count();
    pollfd one{file_, POLLIN, 0};
    if (left <= 0 || ::poll(&one, 1, static_cast<int>(left)) <= 0) break;
    const ssize_t count = ::recv(file_, some.data(), most, 0);
    if (count <= 0) break;
    out.append(some.data(), static_cast<std::size_t>(count));
  }
  return out;
}

int statusOf(const std::string& answer) { return answer.starts_with("HTTP/1.1 ") ? std::atoi(answer.c_str() + 9) : 0; }

}  // namespace kiln::test
