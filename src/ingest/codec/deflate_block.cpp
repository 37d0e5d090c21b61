#include <zlib.h>

#include <algorithm>
#include <climits>
#include <new>

#include "ingest/codec/block_codecs.h"

namespace kiln {
namespace {

// The state of zlib for one stream.
class Inflater {
 public:
  explicit Inflater(DeflateWrapper wrapper) {
    constexpr int kWindowBits = 15, kGzip = 16;
    if (inflateInit2(&state_, kWindowBits + (wrapper == DeflateWrapper::kGzip ? kGzip : 0)) != Z_OK)
      throw std::bad_alloc();
  }
  ~Inflater() { inflateEnd(&state_); }
  Inflater(const Inflater&) = delete;
  Inflater& operator=(const Inflater&) = delete;

  // Moves both spans behind the bytes used; returns zlib's code.
  int step(std::span<const std::byte>& in, std::span<std::byte>& out) {
    const auto most = static_cast<std::size_t>(UINT_MAX);
    state_.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(in.data()));
    state_.avail_in = static_cast<uInt>(std::min(in.size(), most));
    state_.next_out = reinterpret_cast<Bytef*>(out.data());
    state_.avail_out = static_cast<uInt>(std::min(out.size(), most));
    const uInt in_before = state_.avail_in, out_before = state_.avail_out;
    const int code = inflate(&state_, Z_NO_FLUSH);
    in = in.subspan(in_before - state_.avail_in);
    out = out.subspan(out_before - state_.avail_out);
    return code;
  }
  void restart() { inflateReset(&state_); }

 private:
  z_stream state_{};
};

}  // namespace

std::optional<std::size_t> unpackDeflate(std::span<const std::byte> packed, DeflateWrapper wrapper,
                                         std::span<std::byte> out) {
  Inflater stream(wrapper);
  std::span<std::byte> left = out;
  std::byte none{};
  while (true) {
    // zlib needs an address even for no bytes: a stream whose output is full still has to verify its checksum.
    std::span<std::byte> nothing(&none, std::size_t{0});
    const std::size_t in_before = packed.size(), out_before = left.size();
    const int code = stream.step(packed, left.empty() ? nothing : left);
    if (code == Z_MEM_ERROR) throw std::bad_alloc();
    if (code == Z_STREAM_END) {
      if (packed.empty()) return out.size() - left.size();
      if (wrapper == DeflateWrapper::kZlib) return std::nullopt;
      stream.restart();
      continue;
    }
    const bool moved = packed.size() != in_before || left.size() != out_before;
    if ((code != Z_OK && code != Z_BUF_ERROR) || !moved) return std::nullopt;
  }
}

}  // namespace kiln
