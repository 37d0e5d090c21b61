// Finds a place in a text that is valid JSON, in one walk. Enters only values that contain the place and skips all
// others, so that the recursion is as deep as the place, however deep the text is nested.
#include "job/json/json_place.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

namespace kiln {
namespace {

class PlaceWalk {
 public:
  PlaceWalk(std::string_view text, std::string_view place) : text_(text), target_(place) {}

  std::size_t line() {
    skipSpace();
    found_at_ = at_;
    descend("");
    return 1 + static_cast<std::size_t>(std::count(text_.begin(), text_.begin() + found_at_, '\n'));
  }

 private:
  char now() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  bool begins(std::string_view with) const { return text_.substr(at_).starts_with(with); }

  void skipSpace() {
    while (at_ < text_.size()) {
      if (begins("//"))
        at_ = std::min(text_.find('\n', at_), text_.size());
      else if (begins("/*"))
        at_ = std::min(text_.find("*/", at_ + 2), text_.size() - 2) + 2;
      else if (std::string_view(" \t\r\n").find(now()) != std::string_view::npos)
        ++at_;
      else
        return;
    }
  }

  // Reads a string from its opening quote on. Escapes stay unresolved, because no key of a job has escapes.
  std::string_view string() {
    const std::size_t begin = ++at_;
    while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
    const std::string_view out = text_.substr(begin, at_ - begin);
    at_ = std::min(at_ + 1, text_.size());
    return out;
  }

  void skipValue() {
    int depth = 0;
    do {
      skipSpace();
      const char c = now();
      if (c == '"') {
        string();
      } else {
        depth += c == '{' || c == '[' ? 1 : c == '}' || c == ']' ? -1 : 0;
        ++at_;
      }
      // The rest of a number or a word.
      while (depth == 0 && at_ < text_.size() && std::string_view(",]} \t\r\n/").find(now()) == std::string_view::npos)
        ++at_;
    } while (depth > 0 && at_ < text_.size());
  }

  // Returns whether `place` is the target or contains it.
  bool leads(const std::string& place) const {
    if (!target_.starts_with(place)) return false;
    return place.size() == target_.size() || target_[place.size()] == '.' || target_[place.size()] == '[';
  }

  // At a value whose place leads to the target.
  void descend(const std::string& place) {
    if (place.size() == target_.size() || (now() != '{' && now() != '[')) return;
    const bool list = now() == '[';
    ++at_;
    for (std::size_t i = 0;; ++i) {
      skipSpace();
      if (at_ >= text_.size() || now() == '}' || now() == ']') return;
      const std::size_t begin = at_;
      std::string part = place;
      if (list) {
        part += fmt::format("[{}]", i);
      } else {
        if (!place.empty()) part += '.';
        part += string();
        skipSpace();
        ++at_;  // the colon
        skipSpace();
      }
      if (leads(part)) {
        found_at_ = begin;
        return descend(part);
      }
      skipValue();
      skipSpace();
      if (now() == ',') ++at_;
    }
  }

  std::string_view text_, target_;
  std::size_t at_ = 0;
  std::size_t found_at_ = 0;
};

}  // namespace

std::size_t lineOfPlace(std::string_view text, std::string_view place) { return PlaceWalk(text, place).line(); }

}  // namespace kiln
