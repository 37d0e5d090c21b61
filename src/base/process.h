// The name and limits of this machine, and child programs, which are started without a shell.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace kiln {

/// The name of this machine; "an unknown host" if the system has none.
std::string hostName();

/// The number of files this process may have open at once (ulimit -n).
std::uint64_t mostOpenFiles();

/// A running program whose standard error is kept for messages. Destruction kills the program.
class ChildProcess {
 public:
  /// The child's standard input, and with `answers` its standard output, are the other end of a socket; otherwise its
  /// output is discarded. requires: `program` is a path, not a name to look up. throws: Error kNotFound, kIo.
  ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments, bool answers);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  int socket() const { return socket_; }
  void closeSocket();
  /// Returns true once the program has ended; `how` is then empty, or "was ended by signal 11".
  bool hasEnded(std::string& how);
  /// Waits until the program has ended, and returns `how` as hasEnded. `waiting` is called several times a second and
  /// may throw.
  std::string awaitEnd(const std::function<void()>& waiting);
  /// Throws Error kIo: `what` and the program's last error line.
  [[noreturn]] void fail(const std::string& what) const;
  /// The last line that the program wrote to its standard error.
  std::string lastError() const;

 private:
  std::filesystem::path program_;
  int socket_ = -1, error_output_ = -1;
  int process_ = -1;
};

/// Runs a program without input. Returns its standard output; nothing if the program fails, writes to its standard
/// error, or prints more than `most_bytes`. `waiting` is called several times a second and may throw. requires, throws:
/// as ChildProcess; any exception of `waiting`.
std::optional<std::string> outputOf(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                                    std::size_t most_bytes, const std::function<void()>& waiting);

/// Runs a program whose standard input is fed by `write`. Its standard output is discarded. Destruction before `finish`
/// kills the program.
class FedProcess {
 public:
  /// requires, throws: as ChildProcess.
  FedProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments)
      : child_(program, arguments, false) {}

  /// Called several times a second while the program does not read; may throw.
  using WaitHandler = std::function<void()>;
  /// throws: Error kIo, with the program's last error line, if the program stops reading; any exception of `waiting`.
  void write(std::span<const std::byte> data, const WaitHandler& waiting);
  /// Closes the input and waits for the program to end. throws: Error kIo, with the program's last error line, if the
  /// program fails; any exception of `waiting`.
  void finish(const WaitHandler& waiting);

 private:
  ChildProcess child_;
};

}  // namespace kiln
