// Decompresses BloscLZ, the default compressor of Blosc 1, whose own reader is reachable through frames alone.
// Format. A stream alternates runs of literal bytes and matches. The upper three bits of a control byte are the length
// of a match, plus 2; 0 is a run of literals, whose length less 1 is in the lower five bits. Lengths of 9 and more go
// on in bytes up to the first below 255. The distance, less 1, has its upper five bits in the control byte and its
// lower eight in the byte behind the length. All 13 bits set: 16 more bits, the upper byte first, count beyond them.
// Invariant. No byte is read beyond `packed` or before the output, or written beyond the output.
// Source: blosclz.c of c-blosc 1.21, which departs from FastLZ by its lengths and its far matches.
#include "ingest/codec/block_codecs.h"

namespace kiln {
namespace {

constexpr unsigned kLengthShift = 5, kLowBits = 31, kLongMatch = 7, kFarDistance = (kLowBits << 8) + 255;
constexpr std::size_t kLeastMatch = 2;

class BloscLzReader {
 public:
  BloscLzReader(std::span<const std::byte> packed, std::span<std::byte> out) : packed_(packed), out_(out) {}

  std::optional<std::size_t> run() {
    // The first control byte begins with a version in place of a length.
    unsigned control = byte() & kLowBits;
    while (ok_) {
      if (control >> kLengthShift == 0)
        literals(control + 1);
      else
        match(control >> kLengthShift, control & kLowBits);
      if (at_ == packed_.size()) break;
      control = byte();
    }
    return ok_ ? std::optional(written_) : std::nullopt;
  }

 private:
  unsigned byte() {
    if (at_ == packed_.size()) return ok_ = false, 0;
    return std::to_integer<unsigned>(packed_[at_++]);
  }

  void literals(std::size_t count) {
    if (count > packed_.size() - at_ || count > out_.size() - written_) return void(ok_ = false);
    for (std::size_t i = 0; i < count; ++i) out_[written_ + i] = packed_[at_ + i];
    at_ += count;
    written_ += count;
  }

  void match(unsigned short_length, unsigned upper) {
    std::size_t count = short_length + kLeastMatch;
    if (short_length == kLongMatch) {
      unsigned more = 255;
      while (more == 255 && ok_) count += more = byte();
    }
    std::size_t distance = (upper << 8) + byte();
    if (distance == kFarDistance) {
      const unsigned high = byte();
      distance += (high << 8) + byte();
    }
    ++distance;
    if (!ok_ || distance > written_ || count > out_.size() - written_) return void(ok_ = false);
    // A match may reach into itself, and then repeats.
    for (std::size_t i = 0; i < count; ++i) out_[written_ + i] = out_[written_ + i - distance];
    written_ += count;
  }

  std::span<const std::byte> packed_;
  std::span<std::byte> out_;
  std::size_t at_ = 0, written_ = 0;
  bool ok_ = true;
};

}  // namespace

std::optional<std::size_t> unpackBloscLz(std::span<const std::byte> packed, std::span<std::byte> out) {
  return BloscLzReader(packed, out).run();
}

}  // namespace kiln
