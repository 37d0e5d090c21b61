// bzlib decodes and verifies the checksums; this file feeds bzlib and turns its return codes into errors that name the
// byte.
#include "ingest/bytes/bzip2_stream.h"

#include <bzlib.h>
#include <fmt/format.h>

#include "base/error.h"

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

Bzip2Stream::Bzip2Stream(File file, std::uint64_t offset_bytes)
    : file_(std::move(file)), next_offset_bytes_(offset_bytes), input_(1 << 18) {
  begin();
}

Bzip2Stream::~Bzip2Stream() = default;

void Bzip2Stream::begin() {
  auto next = std::make_unique<Decoder>();
  if (!next->ready) throw Error(ErrorCode::kIo, file_.path(), "", "no memory for decompression");
  if (decoder_) {
    next->z.next_in = decoder_->z.next_in;
    next->z.avail_in = decoder_->z.avail_in;
  }
  decoder_ = std::move(next);
}

void Bzip2Stream::fail(const std::string& where, const std::string& what) const {
  const std::uint64_t byte = next_offset_bytes_ - decoder_->z.avail_in;
  throw Error(ErrorCode::kFormat, file_.path(), fmt::format("byte {}, {}", byte, where), what);
}

bool Bzip2Stream::refill() {
  bz_stream& z = decoder_->z;
  if (z.avail_in > 0) return true;
  const std::size_t got = file_.readSomeAt(next_offset_bytes_, input_);
  next_offset_bytes_ += got;
  z.next_in = reinterpret_cast<char*>(input_.data());
  z.avail_in = static_cast<unsigned>(got);
  return got > 0;
}

std::size_t Bzip2Stream::step(std::span<std::byte> out, const std::string& where) {
  const bool more = refill();
  bz_stream& z = decoder_->z;
  const std::size_t room = std::min<std::size_t>(out.size(), 1u << 30);
  z.next_out = reinterpret_cast<char*>(out.data());
  z.avail_out = static_cast<unsigned>(room);
  const int verdict = BZ2_bzDecompress(&z);
  const std::size_t produced = room - z.avail_out;
  if (verdict == BZ_STREAM_END) {
    // The first byte of a next stream is B.
    ended_ = !refill() || *decoder_->z.next_in != 'B';
    if (!ended_) begin();
  } else if (verdict == BZ_MEM_ERROR) {
    throw Error(ErrorCode::kIo, file_.path(), "", "no memory for decompression");
  } else if (verdict != BZ_OK) {
    fail(where, "the compressed data are damaged; get the file again");
  } else if (produced == 0 && !more) {
    fail(where, "the compressed data end here before their end mark; the file is cut short, get it again");
  }
  return produced;
}

void Bzip2Stream::read(std::span<std::byte> out, const std::string& where) {
  std::size_t done = 0;
  while (done < out.size() && !ended_) done += step(out.subspan(done), where);
  if (done < out.size())
    fail(where,
         "the compressed data end here, before the last voxel; the header's dimensions are too large or data are "
         "missing");
}

std::vector<std::string> Bzip2Stream::finish() {
  std::vector<std::byte> dropped(kSkipBytes);
  std::uint64_t beyond = 0;
  while (!ended_) beyond += step(dropped, "after the last slice");
  const std::uint64_t rest = file_.size() - (next_offset_bytes_ - decoder_->z.avail_in);
  std::vector<std::string> notes;
  const std::string name = file_.path().filename().string();
  if (beyond > 0)
    notes.push_back(fmt::format(
        "the compressed data of {} hold more than the header's dimensions need, which is not read: {} bytes", name,
        beyond));
  if (rest > 0) notes.push_back(fmt::format("{}: bytes behind the compressed data not read: {}", name, rest));
  return notes;
}

}  // namespace kiln
