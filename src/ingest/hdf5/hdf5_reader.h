// A worker hdf5_reader, which holds a file open. A crash or a stall of the HDF5 library ends the worker and becomes an
// error of the file.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "base/worker_process.h"
#include "ingest/hdf5/hdf5_protocol.h"

namespace kiln {

/// thread: one at a time.
class Hdf5Reader {
 public:
  /// `memory_bytes` is the limit of the process's address space. throws: Error kUnsupported if Kiln was built without
  /// HDF5, kIo.
  Hdf5Reader(std::filesystem::path file, std::uint64_t memory_bytes);
  /// Returns a text. throws: Error kFormat, naming the file, if the library cannot answer, or the text has more than 16
  /// MiB; kBudget if the text does not fit into `memory_bytes`.
  std::string text(hdf5::Request kind, const std::string& payload, std::uint64_t memory_bytes);
  /// Returns the table of the chunks of a data set; nothing if there are too many chunks. throws: as `text`.
  std::vector<hdf5::ChunkEntry> table(const std::string& path);
  /// Fills `out` with voxels. throws: as `text`, and kFormat if the library gives another number of bytes.
  void read(const std::string& payload, std::span<std::byte> out);

 private:
  std::uint64_t request(hdf5::Request kind, const std::string& payload);
  void requireAtMost(std::uint64_t bytes, std::uint64_t most) const;

  WorkerPlace place_;
  WorkerProcess worker_;
};

/// Limit of the address space of a process, beside the chunks that it reads. unit: bytes.
inline constexpr std::uint64_t kReaderAddressBytes = std::uint64_t{1} << 30;

}  // namespace kiln
