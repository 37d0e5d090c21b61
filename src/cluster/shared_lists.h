// Lists of values that one rank has and all need, or that all have and one needs. They are sent as they are in memory,
// because all ranks are the same program on the same kind of machine.
#pragma once

#include <cstring>
#include <span>
#include <vector>

#include "cluster/ranks.h"

namespace kiln {

/// The values that bytes are. requires: they are of such values, as `bytesOfList` has them.
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

/// Collective. What the first rank has, on all.
template <class T>
void broadcastList(Ranks& ranks, std::vector<T>& list) {
  std::vector<std::byte> bytes = bytesOfList(list);
  ranks.broadcast(bytes);
  list = listFrom<T>(bytes);
}

/// Collective. What each rank has, one behind the other, on the first; nothing on the others.
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
