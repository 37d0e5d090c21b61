#include "base/worker_process.h"

#include <fmt/format.h>
#include <sys/poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <thread>

#include "base/error.h"
#include "base/text.h"
#include "base/worker_protocol.h"

namespace kiln {
namespace {

std::vector<std::string> withLimits(const WorkerLimits& limits, const std::vector<std::string>& arguments) {
  std::vector<std::string> out = {std::to_string(limits.memory_bytes), std::to_string(limits.request_s)};
  out.insert(out.end(), arguments.begin(), arguments.end());
  return out;
}

}  // namespace

WorkerProcess::WorkerProcess(const std::filesystem::path& program, std::string_view library, const WorkerLimits& limits,
                             const std::vector<std::string>& arguments)
    : library_(library), request_s_(limits.request_s), child_(program, withLimits(limits, arguments), true) {}

std::uint64_t WorkerProcess::request(const WorkerPlace& place, std::uint32_t kind, const Parts& payload) {
  WorkerRequestHead head{kind, 0, 0};
  for (const auto& part : payload) head.payload_bytes += part.size();
  send(place, std::as_bytes(std::span(&head, 1)));
  for (const auto& part : payload) send(place, part);
  WorkerAnswerHead answer{};
  receive(place, std::as_writable_bytes(std::span(&answer, 1)));
  if (answer.ok == 1) return answer.bytes;
  if (answer.ok != 0) fail(place, "gave an answer of no form");
  std::string why(std::min<std::uint64_t>(answer.bytes, 1000), '\0');
  receive(place, std::as_writable_bytes(std::span(why)));
  throw Error(ErrorCode::kFormat, place.file, place.part, shown(why));
}

void WorkerProcess::receive(const WorkerPlace& place, std::span<std::byte> answer) {
  while (!answer.empty()) {
    waitFor(place, POLLIN);
    const ssize_t got = ::read(child_.socket(), answer.data(), answer.size());
    if (got < 0 && errno == EINTR) continue;
    if (got == 0 || (got < 0 && errno == ECONNRESET)) failEnded(place);
    if (got < 0) fail(place, fmt::format("cannot be read from ({})", std::strerror(errno)));
    answer = answer.subspan(static_cast<std::size_t>(got));
  }
}

void WorkerProcess::send(const WorkerPlace& place, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    waitFor(place, POLLOUT);
    const ssize_t put = ::send(child_.socket(), bytes.data(), bytes.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (put < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (put < 0 && (errno == EPIPE || errno == ECONNRESET)) failEnded(place);
    if (put < 0) fail(place, fmt::format("cannot be written to ({})", std::strerror(errno)));
    bytes = bytes.subspan(static_cast<std::size_t>(put));
  }
}

void WorkerProcess::waitFor(const WorkerPlace& place, short event) {
  for (;;) {
    pollfd waiting{child_.socket(), event, 0};
    const int ready = ::poll(&waiting, 1, request_s_ * 1000);
    if (ready < 0 && errno == EINTR) continue;
    if (ready == 0) fail(place, fmt::format("did not answer for {} s", request_s_));
    return;
  }
}

void WorkerProcess::fail(const WorkerPlace& place, const std::string& how) const {
  const std::string last = child_.lastError();
  throw Error(ErrorCode::kFormat, place.file, place.part,
              fmt::format("{} failed: its process {}{}", library_, how, last.empty() ? "" : ": " + shown(last)));
}

// The socket closes a moment before the program can be waited for.
void WorkerProcess::failEnded(const WorkerPlace& place) {
  using namespace std::chrono_literals;
  std::string how;
  for (int i = 0; i < 100 && !child_.hasEnded(how); ++i) std::this_thread::sleep_for(10ms);
  fail(place, how.empty() ? "ended" : how);
}

}  // namespace kiln
