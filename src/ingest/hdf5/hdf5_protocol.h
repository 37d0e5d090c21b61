// Messages between Kiln and its program hdf5_reader, which runs the HDF5 library apart from Kiln: a file that crashes
// the library ends that program alone. Numbers have the machine's byte order.
#pragma once

#include <cstdint>

namespace kiln::hdf5 {

enum class Request : std::uint32_t {
  kDescribe = 1,  // answer: JSON of all objects and their attributes
  kLayout,        // payload: a path. answer: JSON of the data set, a line feed, the table of chunks
  kRead,          // payload: a path, a NUL, first and end index of each axis as i64. answer: the voxels of that box
};

struct RequestHead {
  Request kind;
  std::uint32_t payload_bytes;
};

/// Precedes an answer. A failed request is answered by a sentence.
struct AnswerHead {
  std::uint64_t ok;
  std::uint64_t bytes;
};

/// A chunk of the table: place in the file, size, and the filters that were left out (bit i for filter i). An address
/// of all ones is a chunk that does not exist.
struct ChunkEntry {
  std::uint64_t address, bytes, left_out;
};

}  // namespace kiln::hdf5
