#include <zstd.h>
#include <zstd_errors.h>

#include <memory>
#include <new>

#include "ingest/codec/block_codecs.h"

namespace kiln {
namespace {

struct FreeContext {
  void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
};

// A context is large, and a volume has many chunks: each thread keeps a context. unit: about 160 KiB.
ZSTD_DCtx* contextOfThread() {
  thread_local std::unique_ptr<ZSTD_DCtx, FreeContext> context(ZSTD_createDCtx());
  if (!context) context.reset(ZSTD_createDCtx());
  if (!context) throw std::bad_alloc();
  return context.get();
}

}  // namespace

std::optional<std::size_t> unpackZstd(std::span<const std::byte> packed, std::span<std::byte> out) {
  const std::size_t written =
      ZSTD_decompressDCtx(contextOfThread(), out.data(), out.size(), packed.data(), packed.size());
  if (ZSTD_getErrorCode(written) == ZSTD_error_memory_allocation) throw std::bad_alloc();
  if (ZSTD_isError(written)) return std::nullopt;
  return written;
}

}  // namespace kiln
