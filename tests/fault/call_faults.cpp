#include "call_faults.h"

#include <dirent.h>
#include <dlfcn.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <stdexcept>
#include <string_view>

#include "support/system/sanitized.h"
#include "support/system/tool_server.h"

/// The program's main.
int kilnToolMain(int argc, char** argv);

namespace kiln::test {
namespace {

constexpr std::size_t kTextBytes = 1 << 16;

// Shared memory of the test, the server and the program under test.
struct Shared {
  CallFailure failure;
  std::uint64_t after_calls;
  std::array<std::atomic<std::uint64_t>, kCallFailures> calls;  // of each failure
  char failed_call[1024];
  char watched[1024];
  /// The arguments, each terminated by a zero.
  int argument_count;
  char arguments[kTextBytes];
  int status;
};

Shared* shared = nullptr;
// True only in the program under test.
bool armed = false;

// Returns the next definition of a function after this executable's.
template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}
#define KILN_NEXT(name) static auto* const real = next<decltype(::name)>(#name)

bool isWatched(const char* path) {
  return path != nullptr && std::strncmp(path, shared->watched, std::strlen(shared->watched)) == 0;
}

std::string fileOf(int descriptor) {
  KILN_NEXT(readlink);
  char link[32], target[1024];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", descriptor);
  const ssize_t length = real(link, target, sizeof target);
  return std::string(target, length > 0 ? static_cast<std::size_t>(length) : 0);
}

enum Kinds : unsigned { kIoOnly = 0, kReads = 1, kWrites = 2, kInterruptible = 4, kMakes = 8 };

bool failsAs(CallFailure failure, unsigned kinds) {
  switch (failure) {
    case CallFailure::kNone:
    case CallFailure::kIo:
      return true;
    case CallFailure::kInterrupted:
      return (kinds & kInterruptible) != 0;
    case CallFailure::kShort:
      return (kinds & (kReads | kWrites)) != 0;
    case CallFailure::kEnd:
      return (kinds & kReads) != 0;
    case CallFailure::kNoSpace:
      return (kinds & (kWrites | kMakes)) != 0;
  }
  return false;
}

// Counts this call for each failure. Returns true if the call must fail, and sets errno.
bool fails(const char* name, const char* path, unsigned kinds) {
  bool fails_now = false;
  for (std::size_t i = 0; i < kCallFailures; ++i) {
    const auto failure = static_cast<CallFailure>(i);
    if (!failsAs(failure, kinds)) continue;
    const std::uint64_t before = shared->calls[i]++;
    fails_now = fails_now || (failure == shared->failure && before == shared->after_calls);
  }
  if (!fails_now) return false;
  std::snprintf(shared->failed_call, sizeof shared->failed_call, "%s %s", name, path);
  const CallFailure failure = shared->failure;
  errno = failure == CallFailure::kInterrupted ? EINTR : failure == CallFailure::kNoSpace ? ENOSPC : EIO;
  return true;
}

bool failsOn(const char* name, const char* path, unsigned kinds) {
  return armed && isWatched(path) && fails(name, path, kinds);
}

bool failsOn(const char* name, int descriptor, unsigned kinds) {
  if (!armed) return false;
  const int before = errno;
  const std::string file = fileOf(descriptor);
  errno = before;
  return (isWatched(file.c_str()) || file.starts_with("socket:")) && fails(name, file.c_str(), kinds);
}

bool isOurs(int descriptor) { return armed && isWatched(fileOf(descriptor).c_str()); }

// Sets the result of a failed read or write of `bytes`, or reduces `bytes` for a short transfer.
bool endsTransfer(std::size_t& bytes, ssize_t& result, bool reads) {
  result = -1;
  if (shared->failure == CallFailure::kEnd) result = 0;
  if (shared->failure != CallFailure::kShort) return true;
  bytes = std::max(bytes / 2, std::size_t{reads ? 1u : 0u});
  result = 0;
  return bytes == 0;
}

// The program under test is a child of a server process that was forked while the test had a single thread.

int channel[2] = {-1, -1};
int out_file = -1, err_file = -1;

std::string textOf(int file) {
  std::string text(static_cast<std::size_t>(std::max<off_t>(::lseek(file, 0, SEEK_END), 0)), '\0');
  const ssize_t got = ::pread(file, text.data(), text.size(), 0);
  text.resize(got > 0 ? static_cast<std::size_t>(got) : 0);
  return text;
}

[[noreturn]] void runProgram() {
  ::alarm(casesOf(60u, 300u));  // ends a program that hangs
  const int null = ::open("/dev/null", O_RDONLY);
  ::dup2(null, STDIN_FILENO);
  ::dup2(out_file, STDOUT_FILENO);
  ::dup2(err_file, STDERR_FILENO);
  std::vector<char*> arguments;
  char* at = shared->arguments;
  for (int i = 0; i < shared->argument_count; ++i, at += std::strlen(at) + 1) arguments.push_back(at);
  arguments.push_back(nullptr);
  const char* const path = std::getenv("PATH");
  ::setenv("PATH", (std::string(shared->watched) + "/bin:" + (path != nullptr ? path : "")).c_str(), 1);
  armed = true;
  const int exit_code = kilnToolMain(shared->argument_count, arguments.data());
  armed = false;
  std::fflush(nullptr);
  ::_exit(exit_code);
}

[[noreturn]] void serve() {
  char byte;
  while (::read(channel[1], &byte, 1) == 1) {
    const pid_t program = ::fork();
    if (program == 0) runProgram();
    if (program < 0 || ::waitpid(program, &shared->status, 0) != program) shared->status = -1;
    if (::write(channel[1], &byte, 1) != 1) break;
  }
  ::_exit(0);
}

class FaultServer : public ::testing::Environment {
 public:
  void SetUp() override {
    void* const memory = ::mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    out_file = ::memfd_create("output", MFD_CLOEXEC);
    err_file = ::memfd_create("errors", MFD_CLOEXEC);
    if (memory == MAP_FAILED || out_file < 0 || err_file < 0 ||
        ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, channel) != 0)
      throw std::runtime_error("no process can be started that meets faults");
    shared = new (memory) Shared();
    loadForChildren();
    const pid_t server = ::fork();
    if (server < 0) throw std::runtime_error("fork failed");
    if (server == 0) {
      ::close(channel[0]);
      serve();
    }
    ::close(channel[1]);
    server_ = server;
  }
  void TearDown() override {
    ::close(channel[0]);
    ::waitpid(server_, nullptr, 0);
  }

 private:
  pid_t server_ = -1;
};

[[maybe_unused]] const auto* const server = ::testing::AddGlobalTestEnvironment(new FaultServer);

}  // namespace

ToolUnderFault runUnderFault(const std::vector<std::string>& arguments, const std::filesystem::path& watched,
                             const CallFault& fault) {
  shared->failure = fault.failure;
  shared->after_calls = fault.after_calls;
  for (auto& calls : shared->calls) calls = 0;
  shared->failed_call[0] = '\0';
  std::snprintf(shared->watched, sizeof shared->watched, "%s", watched.c_str());
  shared->argument_count = 1;
  std::string text("kiln", 5);
  for (const std::string& argument : arguments) {
    text.append(argument.c_str(), argument.size() + 1);
    ++shared->argument_count;
  }
  if (text.size() > kTextBytes) throw std::runtime_error("too long arguments");
  std::copy(text.begin(), text.end(), shared->arguments);
  for (const int file : {out_file, err_file}) {
    if (::ftruncate(file, 0) != 0 || ::lseek(file, 0, SEEK_SET) != 0) throw std::runtime_error("no memory for output");
  }
  char byte = 0;
  if (::write(channel[0], &byte, 1) != 1 || ::read(channel[0], &byte, 1) != 1 || shared->status == -1)
    throw std::runtime_error("no process can be started that meets faults");
  ToolUnderFault out;
  out.exit_code = WIFEXITED(shared->status) ? WEXITSTATUS(shared->status) : -WTERMSIG(shared->status);
  out.failed_call = shared->failed_call;
  std::copy(shared->calls.begin(), shared->calls.end(), out.calls.begin());
  out.out = textOf(out_file);
  out.err = textOf(err_file);
  return out;
}

}  // namespace kiln::test

using namespace kiln::test;

#define KILN_TRANSFER(name, fd, bytes, kind)                        \
  if (bytes > 1 && failsOn(#name, fd, kind | kInterruptible)) {     \
    ssize_t result;                                                 \
    if (endsTransfer(bytes, result, kind == kReads)) return result; \
  }

extern "C" {

int open(const char* path, int flags, ...) {
  KILN_NEXT(open);
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  if (failsOn("open", path, kInterruptible | ((flags & O_CREAT) != 0 ? kMakes : kIoOnly))) return -1;
  return real(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  return open(path, flags, mode);
}
int openat(int folder, const char* path, int flags, ...) {
  KILN_NEXT(openat);
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
  va_end(list);
  if (folder == AT_FDCWD || *path == '/' ? failsOn("openat", path, kInterruptible)
                                         : failsOn("openat", folder, kInterruptible))
    return -1;
  return real(folder, path, flags, mode);
}
int mkostemps(char* name, int suffix, int flags) {
  KILN_NEXT(mkostemps);
  return failsOn("mkostemps", name, kInterruptible | kMakes) ? -1 : real(name, suffix, flags);
}
FILE* fopen(const char* path, const char* mode) {
  KILN_NEXT(fopen);
  return failsOn("fopen", path, kInterruptible | (*mode == 'r' ? kIoOnly : kMakes)) ? nullptr : real(path, mode);
}
FILE* fopen64(const char* path, const char* mode) { return fopen(path, mode); }
int fclose(FILE* file) {
  KILN_NEXT(fclose);
  const bool failed = failsOn("fclose", ::fileno(file), kInterruptible | kMakes);
  const int result = real(file);
  if (failed) errno = shared->failure == CallFailure::kNoSpace ? ENOSPC : EIO;
  return failed ? EOF : result;
}
int close(int descriptor) {
  KILN_NEXT(close);
  const bool failed = failsOn("close", descriptor, kInterruptible);
  const int error = errno, result = real(descriptor);
  if (failed) errno = error;
  return failed ? -1 : result;
}

ssize_t read(int descriptor, void* data, size_t bytes) {
  KILN_NEXT(read);
  KILN_TRANSFER(read, descriptor, bytes, kReads)
  return real(descriptor, data, bytes);
}
ssize_t pread(int descriptor, void* data, size_t bytes, off_t offset) {
  KILN_NEXT(pread);
  KILN_TRANSFER(pread, descriptor, bytes, kReads)
  return real(descriptor, data, bytes, offset);
}
ssize_t pread64(int descriptor, void* data, size_t bytes, off64_t offset) {
  return pread(descriptor, data, bytes, offset);
}
ssize_t write(int descriptor, const void* data, size_t bytes) {
  KILN_NEXT(write);
  KILN_TRANSFER(write, descriptor, bytes, kWrites)
  return real(descriptor, data, bytes);
}
ssize_t pwrite(int descriptor, const void* data, size_t bytes, off_t offset) {
  KILN_NEXT(pwrite);
  KILN_TRANSFER(pwrite, descriptor, bytes, kWrites)
  return real(descriptor, data, bytes, offset);
}
ssize_t pwrite64(int descriptor, const void* data, size_t bytes, off64_t offset) {
  return pwrite(descriptor, data, bytes, offset);
}
ssize_t send(int descriptor, const void* data, size_t bytes, int flags) {
  KILN_NEXT(send);
  KILN_TRANSFER(send, descriptor, bytes, kWrites)
  return real(descriptor, data, bytes, flags);
}
ssize_t writev(int descriptor, const iovec* pieces, int count) {
  KILN_NEXT(writev);
  std::size_t bytes = 0;
  for (int i = 0; i < count; ++i) bytes += pieces[i].iov_len;
  const std::size_t whole = bytes;
  KILN_TRANSFER(writev, descriptor, bytes, kWrites)
  if (bytes == whole) return real(descriptor, pieces, count);
  std::vector<iovec> fewer(pieces, pieces + count);
  for (iovec& piece : fewer) {
    piece.iov_len = std::min(piece.iov_len, bytes);
    bytes -= piece.iov_len;
  }
  return real(descriptor, fewer.data(), count);
}

int fsync(int descriptor) {
  KILN_NEXT(fsync);
  if (failsOn("fsync", descriptor, kInterruptible | kMakes)) return -1;
  return isOurs(descriptor) ? 0 : real(descriptor);
}
int syncfs(int descriptor) noexcept {
  KILN_NEXT(syncfs);
  if (failsOn("syncfs", descriptor, kMakes)) return -1;
  return isOurs(descriptor) ? 0 : real(descriptor);
}
int ftruncate(int descriptor, off_t size) noexcept {
  KILN_NEXT(ftruncate);
  return failsOn("ftruncate", descriptor, kInterruptible | kMakes) ? -1 : real(descriptor, size);
}
int flock(int descriptor, int operation) noexcept {
  KILN_NEXT(flock);
  return failsOn("flock", descriptor, kInterruptible) ? -1 : real(descriptor, operation);
}
int rename(const char* from, const char* to) noexcept {
  KILN_NEXT(rename);
  return failsOn("rename", to, kMakes) ? -1 : real(from, to);
}
int renameat2(int from_folder, const char* from, int to_folder, const char* to, unsigned flags) noexcept {
  KILN_NEXT(renameat2);
  return failsOn("renameat2", to, kMakes) ? -1 : real(from_folder, from, to_folder, to, flags);
}
int unlink(const char* path) noexcept {
  KILN_NEXT(unlink);
  return failsOn("unlink", path, kIoOnly) ? -1 : real(path);
}
int unlinkat(int folder, const char* path, int flags) noexcept {
  KILN_NEXT(unlinkat);
  return failsOn("unlinkat", folder, kIoOnly) ? -1 : real(folder, path, flags);
}
int remove(const char* path) noexcept {
  KILN_NEXT(remove);
  return failsOn("remove", path, kIoOnly) ? -1 : real(path);
}
int mkdir(const char* path, mode_t mode) noexcept {
  KILN_NEXT(mkdir);
  return failsOn("mkdir", path, kMakes) ? -1 : real(path, mode);
}
int link(const char* from, const char* to) noexcept {
  KILN_NEXT(link);
  return failsOn("link", to, kMakes) ? -1 : real(from, to);
}

int stat(const char* path, struct stat* status) noexcept {
  KILN_NEXT(stat);
  return failsOn("stat", path, kIoOnly) ? -1 : real(path, status);
}
int lstat(const char* path, struct stat* status) noexcept {
  KILN_NEXT(lstat);
  return failsOn("lstat", path, kIoOnly) ? -1 : real(path, status);
}
int fstat(int descriptor, struct stat* status) noexcept {
  KILN_NEXT(fstat);
  return failsOn("fstat", descriptor, kIoOnly) ? -1 : real(descriptor, status);
}
int stat64(const char* path, struct stat64* status) noexcept {
  return stat(path, reinterpret_cast<struct stat*>(status));
}
int lstat64(const char* path, struct stat64* status) noexcept {
  return lstat(path, reinterpret_cast<struct stat*>(status));
}
int fstat64(int descriptor, struct stat64* status) noexcept {
  return fstat(descriptor, reinterpret_cast<struct stat*>(status));
}
ssize_t readlink(const char* path, char* target, size_t bytes) noexcept {
  KILN_NEXT(readlink);
  return failsOn("readlink", path, kIoOnly) ? -1 : real(path, target, bytes);
}
DIR* opendir(const char* path) {
  KILN_NEXT(opendir);
  return failsOn("opendir", path, kIoOnly) ? nullptr : real(path);
}
struct dirent* readdir(DIR* folder) {
  KILN_NEXT(readdir);
  return failsOn("readdir", ::dirfd(folder), kIoOnly) ? nullptr : real(folder);
}
struct dirent64* readdir64(DIR* folder) {
  return reinterpret_cast<struct dirent64*>(readdir(folder));
}

// Stores keep the time of their conversion.
time_t time(time_t* out) noexcept {
  KILN_NEXT(time);
  const time_t now = armed ? 1'000'000'000 : real(nullptr);
  if (out != nullptr) *out = now;
  return now;
}

}  // extern "C"
