// Frames come from their files, not from memory, so that a resumed video equals an uninterrupted video.
#include "sequence/video.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/file/file.h"
#include "base/process.h"
#include "image/file/image_file.h"
#include "image/srgb.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

std::vector<std::byte> overBlack(const Image& image) {
  const SrgbBytes& bytes = SrgbBytes::all();
  std::vector<std::byte> out;
  out.reserve(image.rgba.size() / 4 * 3);
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    // A premultiplied colour is already the colour over black.
    for (std::size_t channel = 0; channel < 3; ++channel) out.push_back(std::byte{bytes.of(image.rgba[i + channel])});
  }
  return out;
}

}  // namespace

std::vector<std::string> encoderArguments(const VideoOptions& options, int width, int height, const std::string& record,
                                          const fs::path& file) {
  const bool webm = extensionOf(options.path) == ".webm";
  std::vector<std::string> out = {"-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"};
  const auto add = [&](std::initializer_list<std::string> more) { out.insert(out.end(), more); };
  add({"-s", fmt::format("{}x{}", width, height), "-r", options.rate.text(), "-i", "-", "-an"});
  // Names the colour matrix of high definition, because players assume different matrices.
  add({"-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv", "-pix_fmt", "yuv420p"});
  add({"-colorspace", "bt709", "-color_primaries", "bt709", "-color_trc", "iec61966-2-1", "-color_range", "tv"});
  if (webm)
    add({"-c:v", "libvpx-vp9", "-crf", "20", "-b:v", "0"});
  else
    add({"-c:v", "libx264", "-crf", "16"});
  // x264's bytes depend on its threads, whose number is that of the cores of a process otherwise.
  add({"-threads", "4"});
  // Leaves out the encoder's name and the time, so that equal frames give equal files.
  add({"-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact"});
  if (!record.empty()) add({"-metadata", "comment=" + record});
  // ffmpeg reads a colon as the end of a protocol's name, and a temporary file has no ending: both are named here.
  const std::string ending = extensionOf(options.path);
  add({"-f", ending == ".mkv" ? "matroska" : ending.substr(1), "file:" + file.string()});
  return out;
}

bool isVideoOf(const VideoOptions& options, const std::string& record, Progress& progress) {
  if (record.empty()) return false;
  // Decodes the frames, and prints the tags as lines "comment=TEXT".
  constexpr std::size_t kMostTags_bytes = 1 << 16;
  const std::optional<std::string> tags =
      outputOf(options.encoder,
               {"-nostdin", "-loglevel", "error", "-xerror", "-i", "file:" + options.path.string(), "-map", "0:v", "-f",
                "null", "-", "-f", "ffmetadata", "pipe:1"},
               kMostTags_bytes, [&] { progress.throwIfCancelled("checking the video"); });
  if (!tags) return false;
  if (tags->find(fmt::format("={}\n", record)) != std::string::npos) return true;
  if (tags->find(fmt::format("={}", kVideoRecord)) == std::string::npos) return false;
  throw Error(ErrorCode::kExists, options.path, "",
              "is a video of another job or of other frames; name another output, or remove it");
}

void writeVideo(const std::vector<fs::path>& pictures, const VideoOptions& options, const std::string& record,
                std::uint64_t memory_bytes, Progress& progress) {
  FileSystem& disk = FileSystem::real();
  disk.replace(options.path, [&](const fs::path& temporary) {
    Image image = readImage(pictures.front(), {}, memory_bytes);
    const int width = image.width, height = image.height;
    FedProcess encoder(options.encoder, encoderArguments(options, width, height, record, temporary));
    const auto waiting = [&] { progress.throwIfCancelled("making the video"); };
    for (std::size_t i = 0; i < pictures.size(); ++i) {
      waiting();
      if (i > 0) image = readImage(pictures[i], {}, memory_bytes);
      if (image.width != width || image.height != height)
        throw Error(ErrorCode::kUsage, pictures[i], "",
                    fmt::format("has {} x {} pixels, but a frame of this video has {} x {}", image.width, image.height,
                                width, height));
      encoder.write(overBlack(image), waiting);
      progress.advance("making the video", "frames", i + 1, pictures.size());
    }
    encoder.finish(waiting);
    // Frames may be removed once the video has its name, so the video must be on the disk before.
    disk.syncFile(temporary);
  });
}

}  // namespace kiln
