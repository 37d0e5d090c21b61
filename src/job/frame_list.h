// Which frames of a sequence are drawn, and where a frame's number stands in the name of a file.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace kiln {

inline constexpr int kLastFrame = 9'999'999;
inline constexpr std::size_t kMostFrames = 1'000'000;

/// "7", "1-100", "1-100x2" (every second), or several of them between commas: each frame once, in the order given.
/// throws: Error kUsage saying what was found, after `option` where one is named.
std::vector<int> parseFrames(std::string_view text, std::string_view option = "");

/// "1-10,20" again: what `parseFrames` reads as these frames. requires: in the order of `parseFrames`.
std::string framesText(const std::vector<int>& frames);

/// Returns whether the path has a place for a frame's number: a run of '#'.
bool hasFramePlace(const std::filesystem::path& pattern);

/// The path with the number in each such place, with zeros in front where it is shorter than the run: "a_####.exr" is
/// "a_0012.exr" for 12.
std::filesystem::path pathOfFrame(const std::filesystem::path& pattern, int frame);

}  // namespace kiln
