#include "frame/lookahead.h"

namespace kiln {

std::vector<BrickKey> Lookahead::after(const BrickKey& drawn, std::size_t count) {
  // Hidden bricks stay hidden, so looking at more of them than this at once gains nothing that the next call has not.
  constexpr std::size_t kLooks = 64;
  while (next_ < in_view_.size() && in_view_[next_].key != drawn) ++next_;
  if (next_ < in_view_.size()) ++next_;
  std::vector<BrickKey> out;
  for (std::size_t i = next_; i < in_view_.size() && i < next_ + kLooks && out.size() < count; ++i) {
    if (!known_hidden_[i]) known_hidden_[i] = is_hidden_(in_view_[i]);
    if (!known_hidden_[i]) out.push_back(in_view_[i].key);
  }
  return out;
}

}  // namespace kiln
