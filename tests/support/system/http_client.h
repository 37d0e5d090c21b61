// A client of raw sockets, which may break every rule of HTTP.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

namespace kiln::test {

class HttpClient {
 public:
  /// Connects to a port of 127.0.0.1, or to a UNIX socket. throws: std::runtime_error.
  explicit HttpClient(std::uint16_t port);
  explicit HttpClient(const std::string& socket_path);
  ~HttpClient();
  HttpClient(const HttpClient&) = delete;
  HttpClient& operator=(const HttpClient&) = delete;

  /// Sends bytes; what the server no longer takes is dropped.
  void send(std::string_view bytes);
  /// Returns all bytes until the server closes, or until `seconds` have passed.
  std::string receive(double seconds = 5);
  /// Returns bytes until they contain `mark`, the server closes, or `seconds` have passed.
  std::string receiveUntil(std::string_view mark, double seconds = 5);
  /// Returns so many bytes; fewer where the server closes, or `seconds` have passed.
  std::string receiveBytes(std::size_t count, double seconds = 5);
  void close();

 private:
  /// Takes bytes while wanted(bytes so far) is their most number.
  std::string received(double seconds, const std::function<std::size_t(const std::string&)>& wanted);
  int file_ = -1;
};

/// The status code of an answer; 0 for no answer.
int statusOf(const std::string& answer);

}  // namespace kiln::test
