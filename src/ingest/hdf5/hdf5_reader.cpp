#include "ingest/hdf5/hdf5_reader.h"

#include <fmt/format.h>

#include "base/error.h"
#include "base/module.h"
#include "ingest/source/json_node.h"

namespace kiln {

Hdf5Reader::Hdf5Reader(std::filesystem::path file, std::uint64_t memory_bytes)
    : place_{std::move(file), ""},
      worker_(programBesideModules("kiln_hdf5_reader", "HDF5 files cannot be read"), "the HDF5 library",
              {.memory_bytes = memory_bytes}, {place_.file.string()}) {}

// Returns the size of the answer that follows.
std::uint64_t Hdf5Reader::request(hdf5::Request kind, const std::string& payload) {
  return worker_.request(place_, static_cast<std::uint32_t>(kind), {std::as_bytes(std::span(payload))});
}

void Hdf5Reader::requireAtMost(std::uint64_t bytes, std::uint64_t most) const {
  if (bytes <= most) return;
  throw Error(ErrorCode::kFormat, place_.file, "",
              fmt::format("its description has {} bytes, more than the {} that are read", bytes, most));
}

std::string Hdf5Reader::text(hdf5::Request kind, const std::string& payload, std::uint64_t memory_bytes) {
  const std::uint64_t bytes = request(kind, payload);
  requireAtMost(bytes, 16 << 20);
  requireHeaderFits(place_.file, bytes, memory_bytes);
  std::string out(bytes, '\0');
  worker_.receive(place_, std::as_writable_bytes(std::span(out)));
  return out;
}

std::vector<hdf5::ChunkEntry> Hdf5Reader::table(const std::string& path) {
  const std::uint64_t bytes = request(hdf5::Request::kTable, path);
  requireAtMost(bytes, hdf5::kMostListedChunks * sizeof(hdf5::ChunkEntry));
  std::vector<hdf5::ChunkEntry> out(bytes / sizeof(hdf5::ChunkEntry));
  worker_.receive(place_, std::as_writable_bytes(std::span(out)));
  return out;
}

void Hdf5Reader::read(const std::string& payload, std::span<std::byte> out) {
  const std::uint64_t bytes = request(hdf5::Request::kRead, payload);
  if (bytes != out.size())
    throw Error(ErrorCode::kFormat, place_.file, "",
                fmt::format("the HDF5 library gives {} bytes of voxels (expected {})", bytes, out.size()));
  worker_.receive(place_, out);
}

}  // namespace kiln
