// The name and limits of this machine, and a child program that reads its input from this process, without a shell.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace kiln {

/// The name of this machine; "an unknown host" if the system has none.
std::string hostName();

/// The number of files this process may have open at once (ulimit -n).
std::uint64_t mostOpenFiles();

/// Runs a program whose standard input is fed by `write`. Its standard output is discarded, its standard error is kept
/// for error messages. Destruction before `finish` kills the program.
class FedProcess {
 public:
  /// requires: `program` is a path, not a name to look up. throws: Error kNotFound, kIo.
  FedProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments);
  ~FedProcess();
  FedProcess(const FedProcess&) = delete;
  FedProcess& operator=(const FedProcess&) = delete;

  /// Called several times a second while the program does not read; may throw.
  using WaitHandler = std::function<void()>;
  /// throws: Error kIo, with the program's last error line, if the program stops reading; any exception of `waiting`.
  void write(std::span<const std::byte> data, const WaitHandler& waiting);
  /// Closes the input and waits for the program to end. throws: Error kIo, with the program's last error line, if the
  /// program fails; any exception of `waiting`.
  void finish(const WaitHandler& waiting);

 private:
  [[noreturn]] void fail(const std::string& what) const;
  void closeInput();

  std::filesystem::path program_;
  int input_ = -1, error_output_ = -1;
  int process_ = -1;
};

}  // namespace kiln
