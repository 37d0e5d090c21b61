// The machine's name, and another program that is fed through a pipe, without a shell.
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

/// How many files this process may have open at once (ulimit -n).
std::uint64_t mostOpenFiles();

/// The program's standard input is what `write` is given, its standard output goes nowhere, and what it complains of is
/// kept. Destroyed before `finish`, it is ended at once.
class FedProcess {
 public:
  /// requires: `program` is a path, not a name to look up. throws: Error kNotFound, kIo.
  FedProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments);
  ~FedProcess();
  FedProcess(const FedProcess&) = delete;
  FedProcess& operator=(const FedProcess&) = delete;

  /// Asked several times a second while the program keeps this one waiting; it may throw.
  using Waiting = std::function<void()>;
  /// throws: Error kIo with the program's last complaint where it takes no more; what `waiting` throws.
  void write(std::span<const std::byte> data, const Waiting& waiting);
  /// Ends its input and waits for it. throws: Error kIo with its last complaint where it fails; what `waiting` throws.
  void finish(const Waiting& waiting);

 private:
  [[noreturn]] void fail(const std::string& what) const;
  void closeInput();

  std::filesystem::path program_;
  int input_ = -1, complaints_ = -1;
  int process_ = -1;
};

}  // namespace kiln
