// Decoded strips, tiles or slices that neighbouring boxes share: each is decoded once while it fits, by one thread
// while the others that want it wait.
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

  /// unit: bytes of decoded blocks; those in use are beside it. thread: with no `get` under way.
  void setCapacity(std::uint64_t bytes) { capacity_bytes_ = bytes; }
  /// The block, by `decode` where it is not here. throws: what `decode` throws; the next to ask tries again.
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
