#include "base/worker_loop.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <new>

#include "base/worker_protocol.h"

namespace kiln {
namespace {

// The socket of answers. Libraries print to standard output, which is their standard error here.
int answers = -1;

constexpr rlim_t kMostMessageBytes = 1 << 20;

bool readAll(void* to, std::size_t bytes) {
  auto* at = static_cast<char*>(to);
  while (bytes > 0) {
    const ssize_t got = ::read(STDIN_FILENO, at, bytes);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

void writeAll(const void* from, std::size_t bytes) {
  const auto* at = static_cast<const char*>(from);
  while (bytes > 0) {
    const ssize_t put = ::write(answers, at, bytes);
    if (put < 0 && errno == EINTR) continue;
    if (put <= 0) ::_exit(1);
    at += put;
    bytes -= static_cast<std::size_t>(put);
  }
}

void send(bool ok, const std::string& text) {
  const WorkerAnswerHead head{ok ? 1u : 0u, text.size()};
  writeAll(&head, sizeof head);
  writeAll(text.data(), text.size());
}

// The kernel ends the process (SIGXCPU) at the soft limit, which grows with each request.
void limitRequest(int seconds) {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  rlimit time{};
  ::getrlimit(RLIMIT_CPU, &time);
  time.rlim_cur = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec + 2 + seconds);
  ::setrlimit(RLIMIT_CPU, &time);
}

// Throws std::bad_alloc for a payload beyond the limit of memory, after passing over the payload.
std::string payloadOf(const WorkerRequestHead& head) try {
  std::string out(head.payload_bytes, '\0');
  if (!readAll(out.data(), out.size())) ::_exit(0);
  return out;
} catch (const std::bad_alloc&) {
  char passed[4096];
  for (std::uint64_t left = head.payload_bytes; left > 0;) {
    const std::size_t bytes = std::min<std::uint64_t>(left, sizeof passed);
    if (!readAll(passed, bytes)) ::_exit(0);
    left -= bytes;
  }
  throw;
}

}  // namespace

WorkerArguments startWorker(int count, char** arguments) {
  if (count < 3) ::_exit(2);
  WorkerArguments out;
  out.memory_bytes = std::strtoull(arguments[1], nullptr, 10);
  out.request_s = std::atoi(arguments[2]);
  out.next = count > 3 ? arguments[3] : nullptr;
  if (out.memory_bytes == 0 || out.request_s <= 0) ::_exit(2);
  answers = ::dup(STDOUT_FILENO);
  if (answers < 0 || ::dup2(STDERR_FILENO, STDOUT_FILENO) < 0) ::_exit(2);
  // Messages are kept in memory: a library that prints without end fails to print.
  const rlimit none{0, 0}, messages{kMostMessageBytes, kMostMessageBytes};
  std::signal(SIGXFSZ, SIG_IGN);
  ::setrlimit(RLIMIT_FSIZE, &messages);
  ::setrlimit(RLIMIT_CORE, &none);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // which reserve terabytes of addresses
  const rlimit memory{out.memory_bytes, out.memory_bytes};
  ::setrlimit(RLIMIT_AS, &memory);
#endif
  return out;
}

void serveRequests(const WorkerArguments& limits, const WorkerAnswer& answer) {
  const std::string too_little =
      "the library needs more memory than the " + std::to_string(limits.memory_bytes >> 20) + " MiB of its process";
  WorkerRequestHead head;
  while (readAll(&head, sizeof head)) {
    limitRequest(limits.request_s);
    try {
      send(true, answer(head.kind, payloadOf(head)));
    } catch (const std::bad_alloc&) {
      send(false, too_little);
    } catch (const std::exception& error) {
      send(false, error.what());
    }
  }
  // A library's cleaning up takes time, and nothing was written.
  ::_exit(0);
}

}  // namespace kiln
