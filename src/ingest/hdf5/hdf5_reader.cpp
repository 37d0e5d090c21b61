#include "ingest/hdf5/hdf5_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.h"
#include "base/module.h"
#include "base/text.h"

namespace kiln {

Hdf5Reader::Hdf5Reader(std::filesystem::path file, std::uint64_t memory_bytes)
    : file_(std::move(file)),
      process_(programBesideModules("kiln_hdf5_reader", "HDF5 files cannot be read"),
               {file_.string(), std::to_string(memory_bytes)}) {}

void Hdf5Reader::require(const std::string& fault) const {
  if (fault.empty()) return;
  throw Error(ErrorCode::kFormat, file_, "", "the HDF5 library failed on this file: its process " + shown(fault));
}

// Returns the size of the answer that follows.
std::uint64_t Hdf5Reader::ask(hdf5::Request request, const std::string& payload) {
  const hdf5::RequestHead head{request, static_cast<std::uint32_t>(payload.size())};
  require(process_.send(std::as_bytes(std::span(&head, 1))));
  require(process_.send(std::as_bytes(std::span(payload))));
  hdf5::AnswerHead answer{};
  require(process_.receive(std::as_writable_bytes(std::span(&answer, 1))));
  if (answer.ok == 1) return answer.bytes;
  std::string why(std::min<std::uint64_t>(answer.bytes, 1000), '\0');
  require(process_.receive(std::as_writable_bytes(std::span(why))));
  throw Error(ErrorCode::kFormat, file_, "", shown(why));
}

void Hdf5Reader::requireAtMost(std::uint64_t bytes, std::uint64_t most) const {
  if (bytes <= most) return;
  throw Error(ErrorCode::kFormat, file_, "",
              fmt::format("its description has {} bytes, more than the {} that are read", bytes, most));
}

std::string Hdf5Reader::text(hdf5::Request request, const std::string& payload) {
  const std::uint64_t bytes = ask(request, payload);
  requireAtMost(bytes, 16 << 20);
  std::string out(bytes, '\0');
  require(process_.receive(std::as_writable_bytes(std::span(out))));
  return out;
}

std::vector<hdf5::ChunkEntry> Hdf5Reader::table(const std::string& path) {
  const std::uint64_t bytes = ask(hdf5::Request::kTable, path);
  requireAtMost(bytes, hdf5::kMostListedChunks * sizeof(hdf5::ChunkEntry));
  std::vector<hdf5::ChunkEntry> out(bytes / sizeof(hdf5::ChunkEntry));
  require(process_.receive(std::as_writable_bytes(std::span(out))));
  return out;
}

void Hdf5Reader::read(const std::string& payload, std::span<std::byte> out) {
  const std::uint64_t bytes = ask(hdf5::Request::kRead, payload);
  if (bytes != out.size())
    throw Error(ErrorCode::kFormat, file_, "",
                fmt::format("the HDF5 library gives {} bytes of voxels (expected {})", bytes, out.size()));
  require(process_.receive(out));
}

}  // namespace kiln
