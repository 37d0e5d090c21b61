#include "convert/manifest_draft.h"

#include <fmt/format.h>

#include <bit>

#include "base/error.h"
#include "base/text.h"
#include "convert/resume/source_state.h"
#include "grid/pyramid.h"
#include "store/codec/brick_codec.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

void requireLabels(const SourceInfo& info, const ConvertOptions& options) {
  const fs::path file = info.files.empty() ? fs::path() : info.files.front();
  if (isFloating(info.type))
    throw Error(ErrorCode::kUsage, file, options.labels ? "--labels" : "",
                fmt::format("labels are whole numbers, and this volume has {}; write it as integers first{}",
                            nameOf(info.type), options.labels ? ", or leave --labels out" : ""));
  if (options.half)
    throw Error(ErrorCode::kUsage, file, "--half", "labels are names, and are not rounded; leave --half out");
}

}  // namespace

void requireBricks(const SourceInfo& info, const ConvertOptions& options) {
  if (options.brick_size < kCellSize || options.brick_size > (1 << 12) ||
      !std::has_single_bit(static_cast<std::uint64_t>(options.brick_size))) {
    throw Error(ErrorCode::kUsage,
                "--brick-size: " + std::to_string(options.brick_size) + " is not a power of two from 8 to 4096");
  }
  if (makesLabels(info, options)) requireLabels(info, options);
}

Manifest draftOf(const SourceInfo& info, const ConvertOptions& options) {
  Manifest manifest;
  manifest.type = info.type;
  manifest.background = info.background;
  manifest.volume_class = makesLabels(info, options) ? VolumeClass::kLabels : info.volume_class;
  manifest.look = info.look;
  if (!info.look.empty()) manifest.format = kFormatVersion;
  manifest.brick_size = options.brick_size;
  for (const VolumeGeometry& geometry : pyramidOf(info.geometry, options.brick_size, options.most_levels)) {
    LevelInfo level;
    level.geometry = geometry;
    if (!info.files.empty()) requireTransform(geometry, info.files.front());
    manifest.levels.push_back(level);
  }
  manifest.source.format = info.format;
  for (const fs::path& file : info.files) manifest.source.files.push_back(utf8OfName(file.string()));
  manifest.source.state = stateOf(info.files, info.trees);
  manifest.source.command = options.command;
  manifest.source.time = options.time;
  manifest.source.vdb = info.vdb;
  return manifest;
}

}  // namespace kiln
