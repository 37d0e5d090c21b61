// zlib decodes and verifies the checksums; this file feeds zlib and turns its return codes into errors that name the
// byte.
// Invariant: `ended_` is set only after zlib has compared the trailer of the last member with its own output.
#include "ingest/bytes/inflate_stream.h"

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>

#include "base/error.h"

namespace kiln {
namespace {

constexpr std::size_t kInputBytes = 1 << 18;

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
    : file_(std::move(file)),
      next_offset_bytes_(offset_bytes),
      wrapper_(wrapper),
      input_(kInputBytes),
      decoder_(std::make_unique<Decoder>(windowBits(wrapper))) {
  if (!decoder_->ready) throw Error(ErrorCode::kIo, file_.path(), "", "no memory for decompression");
}

InflateStream::~InflateStream() = default;

void InflateStream::fail(const std::string& where, const std::string& what) const {
  const std::uint64_t byte = next_offset_bytes_ - decoder_->z.avail_in;
  throw Error(ErrorCode::kFormat, file_.path(), "byte " + std::to_string(byte) + ", " + where, what);
}

bool InflateStream::refill() {
  if (decoder_->z.avail_in > 0) return true;
  if (next_offset_bytes_ >= file_.size()) return false;
  const std::size_t got = file_.readSomeAt(next_offset_bytes_, input_);
  next_offset_bytes_ += got;
  decoder_->z.next_in = reinterpret_cast<Bytef*>(input_.data());
  decoder_->z.avail_in = static_cast<uInt>(got);
  return got > 0;
}

void InflateStream::endMember() {
  z_stream& z = decoder_->z;
  const bool gzip = wrapper_ == StreamWrapper::kGzip;
  // Tests only the first byte of a next member: the second byte may lie in the next chunk, and zlib checks it.
  if (gzip && refill() && *z.next_in == 0x1f) {
    inflateReset(&z);
    return;
  }
  ended_ = true;
  while (gzip && refill() && *z.next_in == 0) {
    ++z.next_in;
    --z.avail_in;
  }
}

std::size_t InflateStream::step(std::span<std::byte> out, const std::string& where) {
  const bool more = refill();
  z_stream& z = decoder_->z;
  const std::size_t room = std::min<std::size_t>(out.size(), 1u << 30);
  z.next_out = reinterpret_cast<Bytef*>(out.data());
  z.avail_out = static_cast<uInt>(room);
  const int verdict = inflate(&z, Z_NO_FLUSH);
  const std::size_t produced = room - z.avail_out;
  if (verdict == Z_STREAM_END) {
    endMember();
  } else if (verdict == Z_MEM_ERROR) {
    throw Error(ErrorCode::kIo, file_.path(), "", "no memory for decompression");
  } else if (verdict != Z_OK && verdict != Z_BUF_ERROR) {
    fail(where, std::string("the compressed data are damaged (") + (z.msg ? z.msg : "needs a dictionary") +
                    "); get the file again");
  } else if (produced == 0 && !more) {
    // zlib may still hold output when the input is used up: the stream is cut only once a step produces nothing.
    fail(where, "the compressed data end here before their end mark; the file is cut short, get it again");
  }
  return produced;
}

std::size_t InflateStream::readSome(std::span<std::byte> out, const std::string& where) {
  std::size_t done = 0;
  while (done < out.size() && !ended_) done += step(out.subspan(done), where);
  return done;
}

void InflateStream::read(std::span<std::byte> out, const std::string& where) {
  const std::size_t got = readSome(out, where);
  if (got < out.size()) {
    fail(where,
         "the compressed data end here, before the last voxel; the header's dimensions are too large or data are "
         "missing");
  }
}

std::vector<std::string> InflateStream::finish() {
  std::vector<std::byte> dropped(kSkipBytes);
  std::uint64_t beyond = 0;
  while (const std::size_t got = readSome(dropped, "after the last slice")) beyond += got;
  std::vector<std::string> notes;
  const std::string name = file_.path().filename().string();
  const auto bytes = [](std::uint64_t count) { return fmt::format("{} byte{}", count, count == 1 ? "" : "s"); };
  if (beyond > 0)
    notes.push_back(
        fmt::format("the compressed data of {} hold {} more than the header's dimensions need, which are not "
                    "read",
                    name, bytes(beyond)));
  if (const std::uint64_t rest = file_.size() - (next_offset_bytes_ - decoder_->z.avail_in); rest > 0)
    notes.push_back(fmt::format("{}: {} behind the compressed data not read", name, bytes(rest)));
  return notes;
}

}  // namespace kiln
