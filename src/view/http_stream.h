// A connected socket as a stream of Boost.Beast.
// Method. Beast's time limits hold for asynchronous calls only: each read and write waits in `poll` until a deadline.
#pragma once

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/error.hpp>
#include <boost/beast/http/error.hpp>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <limits>
#include <utility>

namespace kiln {

/// Owns an open socket.
class SocketFile {
 public:
  explicit SocketFile(int file = -1) : file_(file) {}
  ~SocketFile() { reset(); }
  SocketFile(SocketFile&& other) noexcept : file_(std::exchange(other.file_, -1)) {}
  SocketFile& operator=(SocketFile&& other) noexcept {
    reset();
    file_ = std::exchange(other.file_, -1);
    return *this;
  }
  int get() const { return file_; }
  explicit operator bool() const { return file_ >= 0; }
  void reset() {
    if (file_ >= 0) ::close(std::exchange(file_, -1));
  }

 private:
  int file_;
};

/// Each call waits until the deadline at most. thread: one, but for closed().
class HttpStream {
 public:
  using Clock = std::chrono::steady_clock;
  explicit HttpStream(int file) : file_(file) {}
  /// Sets the deadline. unit: seconds from now.
  void within(double seconds) {
    deadline_ = Clock::now() + lengthOf(seconds);
    renewed_by_ = {};
  }
  /// Sets the deadline, and anew whenever bytes are written: a slow line takes a large answer, a reader that has
  /// stopped ends it. unit: seconds.
  void withinOfProgress(double seconds) {
    within(seconds);
    renewed_by_ = lengthOf(seconds);
  }
  bool late() const { return late_; }
  /// Ends reading with an error after so many bytes.
  void allow(std::uint64_t bytes) { allowed_ = bytes; }

  template <class Buffers>
  std::size_t read_some(const Buffers& buffers, boost::system::error_code& error) {
    for (auto part = boost::asio::buffer_sequence_begin(buffers); part != boost::asio::buffer_sequence_end(buffers);
         ++part) {
      const boost::asio::mutable_buffer buffer = *part;
      if (buffer.size() == 0) continue;
      if (allowed_ == 0) {
        error = boost::beast::http::error::body_limit;
        return 0;
      }
      const std::size_t most = std::min<std::uint64_t>(buffer.size(), allowed_);
      const std::size_t count = moved(POLLIN, error, [&] { return ::recv(file_, buffer.data(), most, MSG_DONTWAIT); });
      allowed_ -= count;
      return count;
    }
    error = {};
    return 0;
  }
  template <class Buffers>
  std::size_t write_some(const Buffers& buffers, boost::system::error_code& error) {
    for (auto part = boost::asio::buffer_sequence_begin(buffers); part != boost::asio::buffer_sequence_end(buffers);
         ++part) {
      const boost::asio::const_buffer buffer = *part;
      if (buffer.size() == 0) continue;
      const std::size_t count = moved(
          POLLOUT, error, [&] { return ::send(file_, buffer.data(), buffer.size(), MSG_DONTWAIT | MSG_NOSIGNAL); });
      if (count > 0 && renewed_by_ > Clock::duration::zero()) deadline_ = Clock::now() + renewed_by_;
      return count;
    }
    error = {};
    return 0;
  }

  /// The forms that throw, which Beast requires.
  template <class Buffers>
  std::size_t read_some(const Buffers& buffers) {
    boost::system::error_code error;
    const std::size_t count = read_some(buffers, error);
    if (error) throw boost::system::system_error(error);
    return count;
  }
  template <class Buffers>
  std::size_t write_some(const Buffers& buffers) {
    boost::system::error_code error;
    const std::size_t count = write_some(buffers, error);
    if (error) throw boost::system::system_error(error);
    return count;
  }

  /// True once the other side has closed. thread: any.
  bool closed() const {
    pollfd one{file_, POLLRDHUP, 0};
    return ::poll(&one, 1, 0) > 0 && (one.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0;
  }
  /// Waits for the first byte of a request. Returns false without one.
  bool waitsForRequest(double seconds) const {
    pollfd one{file_, POLLIN, 0};
    return ::poll(&one, 1, static_cast<int>(seconds * 1000)) > 0 && (one.revents & POLLIN) != 0;
  }
  /// Ends the answer, and takes bytes under way: unread bytes would reset the connection before the client has read.
  void end() {
    constexpr std::size_t kMostDrained = 4 << 20;
    ::shutdown(file_, SHUT_WR);
    std::array<char, 16384> rest;
    within(0.5);
    allow(kMostDrained);
    boost::system::error_code error;
    for (std::size_t taken = 0; taken < kMostDrained && !error;) {
      const std::size_t count = read_some(boost::asio::buffer(rest), error);
      if (count == 0) break;
      taken += count;
    }
  }

 private:
  static Clock::duration lengthOf(double seconds) {
    return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  }
  // Calls `move` until it moves bytes, fails, or the deadline has passed.
  template <class Move>
  std::size_t moved(short event, boost::system::error_code& error, const Move& move) {
    for (;;) {
      const ssize_t count = move();
      if (count > 0) {
        error = {};
        return static_cast<std::size_t>(count);
      }
      if (count == 0) {
        error = boost::asio::error::eof;
        return 0;
      }
      if (errno == EINTR) continue;
      if (errno != EAGAIN && errno != EWOULDBLOCK) {
        error = {errno, boost::system::system_category()};
        return 0;
      }
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline_ - Clock::now()).count();
      pollfd one{file_, event, 0};
      if (left <= 0 || ::poll(&one, 1, static_cast<int>(std::min<std::int64_t>(left + 1, 60'000))) == 0) {
        if (Clock::now() < deadline_) continue;
        late_ = true;
        error = boost::asio::error::timed_out;
        return 0;
      }
    }
  }

  const int file_;
  Clock::time_point deadline_{};
  Clock::duration renewed_by_{};  // by each write; zero: never
  bool late_ = false;
  std::uint64_t allowed_ = std::numeric_limits<std::uint64_t>::max();
};

}  // namespace kiln
