#include "ingest/bytes/inflate_stream.h"

#include <zlib.h>

namespace kiln {
namespace {

// zlib.h: adding 16 selects the gzip wrapper alone, a negative number selects a stream without wrapper.
int windowBits(StreamWrapper wrapper) {
  return wrapper == StreamWrapper::kGzip ? MAX_WBITS + 16 : wrapper == StreamWrapper::kZlib ? MAX_WBITS : -MAX_WBITS;
}

}  // namespace

struct InflateStream::Decoder {
  explicit Decoder(int window_bits) : ready(inflateInit2(&z, window_bits) == Z_OK) {}
  ~Decoder() {
    if (ready) inflateEnd(&z);
  }
  Decoder(const Decoder&) = delete;
  Decoder& operator=(const Decoder&) = delete;

  z_stream z{};
  bool ready;
};

InflateStream::InflateStream(File file, std::uint64_t offset_bytes, StreamWrapper wrapper)
    : PackedStream(std::move(file), offset_bytes),
      wrapper_(wrapper),
      decoder_(std::make_unique<Decoder>(windowBits(wrapper))) {
  if (!decoder_->ready) failForMemory();
}

InflateStream::~InflateStream() = default;

PackedStream::Step InflateStream::decode(std::span<const std::byte> packed, std::span<std::byte> out) {
  z_stream& z = decoder_->z;
  z.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(packed.data()));
  z.avail_in = static_cast<uInt>(packed.size());
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(out.size());
  const int verdict = inflate(&z, Z_NO_FLUSH);
  Step step{packed.size() - z.avail_in, out.size() - z.avail_out, Verdict::kGoesOn, {}};
  if (verdict == Z_STREAM_END) {
    step.verdict = Verdict::kEnded;
  } else if (verdict == Z_MEM_ERROR) {
    step.verdict = Verdict::kNoMemory;
  } else if (verdict != Z_OK && verdict != Z_BUF_ERROR) {
    step.verdict = Verdict::kDamaged;
    step.complaint = z.msg != nullptr ? z.msg : "needs a dictionary";
  }
  return step;
}

bool InflateStream::beginAgain(std::byte first) {
  if (wrapper_ != StreamWrapper::kGzip || first != std::byte{0x1f}) return false;
  inflateReset(&decoder_->z);
  return true;
}

}  // namespace kiln
