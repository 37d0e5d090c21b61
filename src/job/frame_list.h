// The frames of a sequence to draw, and the place of the frame's number in a file name.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace kiln {

inline constexpr int kLastFrame = 9'999'999;
inline constexpr std::size_t kMostFrames = 1'000'000;

/// Parses "7", "1-100", "1-100x2" (every second), or a list with commas. Returns each frame once, in the given order.
/// throws: Error kUsage naming the text, after `option` if not empty.
std::vector<int> parseFrames(std::string_view text, std::string_view option = "");

/// Returns the text that `parseFrames` reads as these frames, such as "1-10,20". requires: in the order of
/// `parseFrames`.
std::string framesText(const std::vector<int>& frames);

/// Returns the length of the existing folder at the pattern's beginning, such as a job's folder. Marks in the folder's
/// name are letters, not places for numbers or eyes.
std::size_t literalPart(const std::string& pattern, char mark);

/// Returns whether the path has a place for a frame's number: a run of '#'.
bool hasFramePlace(const std::filesystem::path& pattern);

/// Returns a name like the path's, with a place: "a_####.exr" for "a.exr".
std::filesystem::path withFramePlace(const std::filesystem::path& path);

/// Returns the path with the number in each run of `#`, filled with zeros: "a_####.exr" is "a_0012.exr" for 12.
std::filesystem::path pathOfFrame(const std::filesystem::path& pattern, int frame);

}  // namespace kiln
