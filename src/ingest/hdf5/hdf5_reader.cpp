#include "ingest/hdf5/hdf5_reader.h"

#include <fmt/format.h>

#include <cstring>

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

std::vector<std::byte> Hdf5Reader::answer(hdf5::Request request, const std::string& payload, std::uint64_t most_bytes) {
  const std::uint64_t bytes = ask(request, payload);
  if (bytes > most_bytes)
    throw Error(ErrorCode::kFormat, file_, "",
                fmt::format("its description has {} bytes, more than the {} that are read", bytes, most_bytes));
  std::vector<std::byte> out(bytes);
  require(process_.receive(out));
  return out;
}

void Hdf5Reader::answerInto(hdf5::Request request, const std::string& payload, std::span<std::byte> out) {
  const std::uint64_t bytes = ask(request, payload);
  if (bytes != out.size())
    throw Error(ErrorCode::kFormat, file_, "",
                fmt::format("the HDF5 library gives {} bytes of voxels (expected {})", bytes, out.size()));
  require(process_.receive(out));
}

}  // namespace kiln
