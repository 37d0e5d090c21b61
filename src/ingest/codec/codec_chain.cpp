#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "base/error.h"
#include "ingest/codec/byte_codec.h"

namespace kiln {

void ChunkPlace::fail(const std::string& what) const { throw Error(ErrorCode::kFormat, file, where, what); }

std::uint64_t CodecChain::packedBytes(std::uint64_t bytes) const {
  for (const auto& codec : codecs_) bytes = codec->packedBytes(bytes);
  return bytes;
}

std::uint64_t CodecChain::scratchBytes(std::uint64_t bytes) const {
  // Between two codecs lie the input and the output of a step.
  std::uint64_t between = 0, within = 0;
  for (std::size_t i = 0; i < codecs_.size(); ++i) {
    within = std::max(within, codecs_[i]->scratchBytes(bytes));
    bytes = codecs_[i]->packedBytes(bytes);
    if (i + 1 < codecs_.size()) between = std::max(between, 2 * bytes);
  }
  return between + within;
}

void CodecChain::decode(std::span<const std::byte> packed, std::span<std::byte> out, const ChunkPlace& place) const {
  const auto require = [&](std::size_t got) {
    if (got != out.size()) place.fail(fmt::format("the chunk has {} bytes decoded (expected {})", got, out.size()));
  };
  if (codecs_.empty()) {
    require(packed.size());
    std::memcpy(out.data(), packed.data(), out.size());
    return;
  }
  // The room of each step: what the codecs before it, in the order of encoding, make of `out` at most.
  std::vector<std::uint64_t> room = {out.size()};
  for (const auto& codec : codecs_) room.push_back(codec->packedBytes(room.back()));
  std::vector<std::byte> from, to;
  for (std::size_t i = codecs_.size() - 1; i > 0; --i) {
    to.resize(room[i]);
    to.resize(codecs_[i]->decode(packed, to, place));
    std::swap(from, to);
    packed = from;
  }
  require(codecs_.front()->decode(packed, out, place));
}

}  // namespace kiln
