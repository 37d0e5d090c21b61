// A cache of decoded strips, tiles, chunks or slices, which neighbouring boxes share. The block that is needed last, or
// without an order of boxes the block that was used first, makes room. One thread decodes a block while other threads
// that need the block wait.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "ingest/source/brick_order.h"

namespace kiln {

class BlockCache {
 public:
  struct Key {
    std::int64_t slice = 0, block = 0;
    auto operator<=>(const Key&) const = default;
  };
  using Bytes = std::vector<std::byte>;
  /// The voxels in a block, and the first voxel of the box that is being read.
  struct Use {
    VoxelBox block;
    VoxelCoord box;
  };

  /// Cost of a cached block beside its bytes, also of an empty block. unit: bytes.
  static constexpr std::uint64_t kOwnBytes = 256;

  /// unit: bytes of cached blocks; blocks in use are not counted. thread: not during a `get`.
  void setCapacity(std::uint64_t bytes) { capacity_bytes_ = bytes; }
  /// Announces the order of boxes. thread: not during a `get`.
  void setOrder(const BrickOrder& order) { order_ = order; }
  /// Returns the block, decoded by `decode` if it is not cached. `decode` gets the memory of a dropped block, of any
  /// size and contents, which it may return filled. Without a use, blocks make room in the order of their last use.
  /// throws: the exceptions of `decode`; the next call then decodes again.
  /// thread: any.
  std::shared_ptr<const Bytes> get(const Key& key, const std::function<Bytes(Bytes spare)>& decode,
                                   const std::optional<Use>& use = {});
  /// The number of calls of `decode` that returned.
  std::uint64_t decodings() const { return decodings_; }

 private:
  struct Block {
    std::mutex mutex;  // held while decoding
    std::shared_ptr<const Bytes> bytes;
  };
  // Memory of dropped blocks. Each thread has a heap of its own: blocks that are freed in one heap and allocated in
  // another would take far more memory than the cache holds.
  class Spares {
   public:
    Bytes take();
    void put(Bytes bytes);

   private:
    static constexpr std::size_t kMost = 16;
    std::mutex mutex_;
    std::vector<Bytes> spares_;
  };
  struct Entry {
    std::shared_ptr<Block> block;
    std::uint64_t size_bytes = 0;  // 0 until decoded
    ReadTime due = 0;
  };
  std::shared_ptr<Block> find(const Key& key, const std::optional<Use>& use);
  ReadTime dueOf(const std::optional<Use>& use);
  std::shared_ptr<const Bytes> decoded(const std::function<Bytes(Bytes spare)>& decode);
  void makeRoom(const Key& key);
  void charge(const Key& key, const std::shared_ptr<Block>& block);
  void dropLast();

  std::uint64_t capacity_bytes_ = 64 << 20;
  std::optional<BrickOrder> order_;
  std::atomic<std::uint64_t> decodings_ = 0;
  const std::shared_ptr<Spares> spares_ = std::make_shared<Spares>();  // outlives blocks in use
  std::mutex mutex_;                                                   // guards the members below
  std::map<Key, Entry> entries_;
  std::set<std::pair<ReadTime, Key>> decoded_;     // by the time of the next use
  std::uint64_t used_bytes_ = 0, last_bytes_ = 0;  // of all decoded blocks, of the last one
  ReadTime uses_ = 0;
};

}  // namespace kiln
