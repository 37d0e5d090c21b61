#include "ingest/bytes/bzip2_stream.h"

#include <bzlib.h>

namespace kiln {

struct Bzip2Stream::Decoder {
  Decoder() : ready(BZ2_bzDecompressInit(&z, 0, 0) == BZ_OK) {}
  ~Decoder() {
    if (ready) BZ2_bzDecompressEnd(&z);
  }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  bz_stream z{};
  bool ready;
};

Bzip2Stream::Bzip2Stream(File file, std::uint64_t offset_bytes) : PackedStream(std::move(file), offset_bytes) {
  begin();
}

Bzip2Stream::~Bzip2Stream() = default;

void Bzip2Stream::begin() {
  decoder_.reset();
  decoder_ = std::make_unique<Decoder>();
  if (!decoder_->ready) failForMemory();
}

PackedStream::Step Bzip2Stream::decode(std::span<const std::byte> packed, std::span<std::byte> out) {
  bz_stream& z = decoder_->z;
  z.next_in = const_cast<char*>(reinterpret_cast<const char*>(packed.data()));
  z.avail_in = static_cast<unsigned>(packed.size());
  z.next_out = reinterpret_cast<char*>(out.data());
  z.avail_out = static_cast<unsigned>(out.size());
  const int verdict = BZ2_bzDecompress(&z);
  Step step{packed.size() - z.avail_in, out.size() - z.avail_out, Verdict::kDamaged, {}};
  if (verdict == BZ_OK) step.verdict = Verdict::kGoesOn;
  if (verdict == BZ_STREAM_END) step.verdict = Verdict::kEnded;
  if (verdict == BZ_MEM_ERROR) step.verdict = Verdict::kNoMemory;
  return step;
}

bool Bzip2Stream::beginAgain(std::byte first) {
  if (first != std::byte{'B'}) return false;
  begin();
  return true;
}

}  // namespace kiln
