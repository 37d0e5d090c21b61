// A worker (base/worker_loop.h) that answers a request, or fails in the way that its kind names.
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <string>

#include "base/worker_loop.h"

namespace {

std::string answer(std::uint32_t kind, const std::string& payload) {
  volatile bool forever = true;
  switch (kind) {
    case 0:
      return payload + payload;
    case 1:
      throw kiln::WorkerRefusal("has no meaning");
    case 2:
      std::fputs("first line\nan assertion failed\n", stderr);
      std::abort();
    case 3:
      while (forever) ::pause();
      break;
    case 4:
      while (forever) {
      }
      break;
    case 5:
      return std::string(std::size_t{1} << 40, 'x');
    case 6:
      ::_exit(0);
    case 8:
      for (int i = 0; i < 300'000; ++i) std::puts("a library that prints");
      return "printed";
    default:
      ::_exit(3);
  }
  return {};
}

}  // namespace

int main(int count, char** arguments) { kiln::serveRequests(kiln::startWorker(count, arguments), answer); }
