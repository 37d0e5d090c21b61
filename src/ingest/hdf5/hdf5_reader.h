// One process of the program hdf5_reader with a file that it holds open. A file that crashes or stalls the HDF5 library
// ends that process and becomes an error.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/process.h"
#include "ingest/hdf5/hdf5_protocol.h"

namespace kiln {

/// thread: one at a time.
class Hdf5Reader {
 public:
  /// `memory_bytes` is the limit of the process's address space. throws: Error kUnsupported if Kiln was built without
  /// HDF5, kIo.
  Hdf5Reader(std::filesystem::path file, std::uint64_t memory_bytes);
  /// Returns the answer to a request. throws: Error kFormat, naming the file, if the library cannot answer, or the
  /// answer has more than `most_bytes`.
  std::vector<std::byte> answer(hdf5::Request request, const std::string& payload, std::uint64_t most_bytes);
  /// Fills `out`. throws: as `answer`, and kFormat if the answer has another size.
  void answerInto(hdf5::Request request, const std::string& payload, std::span<std::byte> out);

 private:
  std::uint64_t ask(hdf5::Request request, const std::string& payload);
  void require(const std::string& fault) const;

  std::filesystem::path file_;
  AnsweringProcess process_;
};

/// Limit of the process that describes a file. The library and its tables take a tenth. unit: bytes.
inline constexpr std::uint64_t kDescribeMemoryBytes = std::uint64_t{1} << 30;

}  // namespace kiln
