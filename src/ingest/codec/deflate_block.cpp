#include <libdeflate.h>

#include <memory>
#include <new>

#include "ingest/codec/block_codecs.h"

namespace kiln {
namespace {

struct FreeDecompressor {
  void operator()(libdeflate_decompressor* state) const { libdeflate_free_decompressor(state); }
};

}  // namespace

std::optional<std::size_t> unpackDeflate(std::span<const std::byte> packed, DeflateWrapper wrapper,
                                         std::span<std::byte> out) {
  // 11 KB, for one thread at a time.
  const std::unique_ptr<libdeflate_decompressor, FreeDecompressor> state(libdeflate_alloc_decompressor());
  if (!state) throw std::bad_alloc();
  const auto unpackMember =
      wrapper == DeflateWrapper::kGzip ? libdeflate_gzip_decompress_ex : libdeflate_zlib_decompress_ex;
  std::byte none{};
  std::size_t done = 0;
  while (true) {
    std::byte* const to = out.empty() ? &none : out.data() + done;  // libdeflate computes with the address of no bytes
    std::size_t taken = 0, given = 0;
    if (unpackMember(state.get(), packed.data(), packed.size(), to, out.size() - done, &taken, &given) !=
        LIBDEFLATE_SUCCESS)
      return std::nullopt;
    done += given;
    packed = packed.subspan(taken);
    if (packed.empty()) return done;
    if (wrapper == DeflateWrapper::kZlib) return std::nullopt;
  }
}

}  // namespace kiln
