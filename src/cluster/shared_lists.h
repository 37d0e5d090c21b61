// Broadcasts and gathers lists of values. Values are sent as stored in memory, because all ranks run an identical
// program on machines of equal kind.
#pragma once

#include <cstring>
#include <span>
#include <vector>

#include "cluster/ranks.h"

namespace kiln {

/// Converts bytes to a list of values. requires: `bytes` come from `bytesOfList` of the same type.
template <class T>
std::vector<T> listFrom(std::span<const std::byte> bytes) {
  std::vector<T> out(bytes.size() / sizeof(T));
  if (!out.empty()) std::memcpy(out.data(), bytes.data(), out.size() * sizeof(T));
  return out;
}

template <class T>
std::vector<std::byte> bytesOfList(const std::vector<T>& list) {
  const auto bytes = std::as_bytes(std::span(list));
  return {bytes.begin(), bytes.end()};
}

/// Collective. Copies rank 0's list to all ranks.
template <class T>
void broadcastList(Ranks& ranks, std::vector<T>& list) {
  std::vector<std::byte> bytes = bytesOfList(list);
  ranks.broadcast(bytes);
  list = listFrom<T>(bytes);
}

/// Collective. Returns on rank 0 the lists of all ranks, concatenated in the order of ranks; an empty list on all
/// further ranks.
template <class T>
std::vector<T> gatherLists(Ranks& ranks, const std::vector<T>& list) {
  std::vector<T> out;
  for (const std::vector<std::byte>& bytes : ranks.gather(bytesOfList(list))) {
    const std::vector<T> some = listFrom<T>(bytes);
    out.insert(out.end(), some.begin(), some.end());
  }
  return out;
}

}  // namespace kiln
