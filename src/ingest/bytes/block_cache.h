// A least-recently-used cache of decoded strips, tiles or slices, which neighbouring boxes share. One thread decodes a
// block while other threads that need the block wait.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace kiln {

class BlockCache {
 public:
  struct Key {
    std::int64_t slice = 0, block = 0;
    auto operator<=>(const Key&) const = default;
  };
  using Bytes = std::vector<std::byte>;

  /// Cost of a cached block beside its bytes, also of an empty block. unit: bytes.
  static constexpr std::uint64_t kOwnBytes = 256;

  /// unit: bytes of cached blocks; blocks in use are not counted. thread: not during a `get`.
  void setCapacity(std::uint64_t bytes) { capacity_bytes_ = bytes; }
  /// Returns the block, decoded by `decode` if it is not cached. throws: the exceptions of `decode`; the next call
  /// then decodes again.
  /// thread: any.
  std::shared_ptr<const Bytes> get(const Key& key, const std::function<Bytes()>& decode);

 private:
  struct Block {
    std::mutex mutex;  // held while decoding
    std::shared_ptr<const Bytes> bytes;
  };
  struct Entry {
    std::shared_ptr<Block> block;
    std::uint64_t size_bytes = 0;  // 0 until decoded
    std::list<Key>::iterator use;
  };
  std::shared_ptr<Block> find(const Key& key);
  void charge(const Key& key, const std::shared_ptr<Block>& block);

  std::uint64_t capacity_bytes_ = 64 << 20;
  std::mutex mutex_;
  std::map<Key, Entry> entries_;
  std::list<Key> uses_;  // most recent first
  std::uint64_t used_bytes_ = 0;
};

}  // namespace kiln
