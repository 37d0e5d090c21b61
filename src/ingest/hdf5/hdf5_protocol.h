// Requests to the worker hdf5_reader, which runs the HDF5 library (base/worker_process.h), and its answers. Numbers
// have the machine's byte order.
#pragma once

#include <cstdint>

namespace kiln::hdf5 {

enum class Request : std::uint32_t {
  kDescribe = 1,  // payload: a path or nothing. answer: JSON of that path, of objects below, and of all other objects
  kLayout,        // payload: a path. answer: JSON of the data set
  kTable,         // payload: a path. answer: the table of chunks; nothing for more than kMostListedChunks
  kRead,          // payload: a path, a NUL, first and end index of each axis as i64. answer: the voxels of that box
};

/// HDF5 1.10 walks the whole index for each chunk. Measured: 6,400 chunks take 0.17 s, so the limit takes about 1.6 s.
constexpr std::uint64_t kMostListedChunks = 20'000;

/// A chunk of the table: place in the file, size, and the filters that were left out (bit i for filter i). An address
/// of all ones is a chunk that does not exist.
struct ChunkEntry {
  std::uint64_t address, bytes, left_out;
};

}  // namespace kiln::hdf5
