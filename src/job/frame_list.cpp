#include "job/frame_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>
#include <system_error>

#include "base/error.h"

namespace kiln {
namespace {

Error refusedFrames(std::string_view text, std::string_view option) {
  return Error(ErrorCode::kUsage, std::filesystem::path(option), "",
               fmt::format("expected numbers from 0 to {} such as 7, 1-100, 1-100x2 or 1-10,20 (found '{}')",
                           kLastFrame, text.substr(0, 60)));
}

// Reads a number off the front.
std::optional<int> takeFrameNumber(std::string_view& text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || number < 0 || number > kLastFrame || text.front() == '-') return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

bool take(std::string_view& text, char c) {
  if (!text.starts_with(c)) return false;
  text.remove_prefix(1);
  return true;
}

}  // namespace

std::vector<int> parseFrames(std::string_view text, std::string_view option) {
  std::vector<int> out;
  std::set<int> seen;
  std::string_view rest = text;
  do {
    while (take(rest, ' ')) {
    }
    const std::optional<int> first = takeFrameNumber(rest);
    const std::optional<int> last = first && take(rest, '-') ? takeFrameNumber(rest) : first;
    const std::optional<int> step = last && take(rest, 'x') ? takeFrameNumber(rest) : 1;
    if (!first || !last || !step || *step < 1 || *last < *first) throw refusedFrames(text, option);
    for (int frame = *first; frame <= *last; frame += *step) {
      if (seen.insert(frame).second) out.push_back(frame);
      if (out.size() > kMostFrames)
        throw Error(ErrorCode::kUsage, std::filesystem::path(option), "",
                    fmt::format("'{}' are more than {} numbers", text.substr(0, 60), kMostFrames));
    }
  } while (take(rest, ','));
  if (!rest.empty()) throw refusedFrames(text, option);
  return out;
}

std::string framesText(const std::vector<int>& frames) {
  std::string out;
  for (std::size_t i = 0; i < frames.size();) {
    std::size_t last = i;
    while (last + 1 < frames.size() && frames[last + 1] == frames[last] + 1) ++last;
    if (!out.empty()) out += ',';
    out += last == i ? fmt::format("{}", frames[i]) : fmt::format("{}-{}", frames[i], frames[last]);
    i = last + 1;
  }
  return out;
}

std::size_t literalPart(const std::string& pattern, char mark) {
  std::size_t out = 0;
  for (std::size_t slash = pattern.find('/'); slash != std::string::npos; slash = pattern.find('/', slash + 1)) {
    const std::string folder = pattern.substr(0, slash);
    std::error_code ignored;
    if (folder.find(mark) == std::string::npos) continue;
    if (!std::filesystem::is_directory(folder, ignored)) break;
    out = slash;
  }
  return out;
}

bool hasFramePlace(const std::filesystem::path& pattern) {
  const std::string text = pattern.string();
  return text.find('#', literalPart(text, '#')) != std::string::npos;
}

std::filesystem::path withFramePlace(const std::filesystem::path& path) {
  return path.parent_path() / (path.stem().string() + "_####" + path.extension().string());
}

std::filesystem::path pathOfFrame(const std::filesystem::path& pattern, int frame) {
  const std::string text = pattern.string();
  const std::size_t literal = literalPart(text, '#');
  std::string out = text.substr(0, literal);
  for (std::size_t i = literal; i < text.size();) {
    const std::size_t end = std::min(text.find_first_not_of('#', i), text.size());
    if (end == i)
      out += text[i++];
    else
      out += fmt::format("{:0{}}", frame, end - i);
    i = std::max(i, end);
  }
  return out;
}

}  // namespace kiln
