#include "source_arguments.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/error.h"
#include "base/nearest_word.h"
#include "base/shell_text.h"
#include "image/pixel_rect.h"
#include "ingest/volume_format.h"
#include "job_arguments.h"

namespace kiln::tool {

std::vector<double> parseNumbers(const std::string& text, char separator, const char* option, const char* expected) {
  std::vector<double> out;
  for (const std::string_view part : splitAt(text, separator)) {
    const std::optional<double> value = decimalOf<double>(part);
    if (!value) throw Error(ErrorCode::kUsage, fmt::format("{}: expected {}, found '{}'", option, expected, text));
    out.push_back(*value);
  }
  return out;
}

std::pair<int, int> parseSize(const std::string& text, const char* option) {
  const std::vector<double> values =
      parseNumbers(text, text.find('x') != std::string::npos ? 'x' : ',', option, "WIDTHxHEIGHT");
  if (values.size() != 2 || values[0] != std::floor(values[0]) || values[1] != std::floor(values[1]) ||
      std::abs(values[0]) > 1e6 || std::abs(values[1]) > 1e6) {
    throw Error(ErrorCode::kUsage, fmt::format("{}: expected WIDTHxHEIGHT, found '{}'", option, text));
  }
  // Tested here, before the memory of the picture is planned.
  if (std::min(values[0], values[1]) < 1 || std::max(values[0], values[1]) > kLargestSide_px)
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: each side must be from 1 to {} pixels, found '{}'", option, kLargestSide_px, text));
  return {static_cast<int>(values[0]), static_cast<int>(values[1])};
}

CLI::Validator wholeNumberFrom(int least, std::int64_t most) {
  const auto refused = [least, most](std::string& text) {
    const std::optional<std::int64_t> value = decimalOf<std::int64_t>(text);
    if (value && *value >= least && *value <= most) return std::string();
    if (most < INT64_MAX) return fmt::format("expected a whole number from {} to {}, found '{}'", least, most, text);
    return fmt::format("expected a whole number from {} on, found '{}'", least, text);
  };
  return {refused, ""};
}

CLI::Validator numberFrom(double least, double most) {
  const auto refused = [least, most](std::string& text) {
    const std::optional<double> value = decimalOf<double>(text);
    if (value && *value >= least && *value <= most) return std::string();
    return fmt::format("expected a number from {} to {}, found '{}'", least, most, text);
  };
  return {refused, ""};
}

CLI::Validator oneOf(std::span<const std::string_view> words) {
  const auto refused = [words](std::string& text) {
    if (std::ranges::find(words, text) != words.end()) return std::string();
    return fmt::format("expected one of {}, found '{}'{}", fmt::join(words, ", "), text, meantWordHint(text, words));
  };
  return {refused, ""};
}

void refuseVolumeFile(const std::filesystem::path& path, const char* wanted) {
  const VolumeFormat format = volumeFormatOf(path);
  if (format.name.empty()) return;
  if (!format.read)
    throw Error(ErrorCode::kUsage, path, "",
                fmt::format("is {} file, not {}, and is not read; convert it to NRRD, MetaImage, NIfTI, OpenVDB or raw",
                            format.name, wanted));
  std::filesystem::path bare = path;
  if (bare.extension() == ".gz") bare.replace_extension();
  bare.replace_extension();
  throw Error(ErrorCode::kUsage, path, "",
              fmt::format("is {} volume, not {}; kiln convert {} {} makes a store of it, kiln render {} -o {} "
                          "draws it",
                          format.name, wanted, shellText(path.string()), shellText(bare.string() + ".kiln"),
                          shellText(path.string()), shellText(bare.string() + ".png")));
}

void addSourceArguments(CLI::App& command, OptionFacts& facts, SourceWords& a) {
  const std::string group = nameOf(OptionGroup::kForeign);
  const auto add = [&](const char* name, const char* type, auto& value, const char* help) {
    return command.add_option(name, value, help)->type_name(type)->group(group);
  };
  add("--dims", "X,Y,Z", a.dims, "Headerless raw file: voxels along x, y, z.");
  facts.offer(add("--type", "TYPE", a.type, "Headerless raw file: u8 i8 u16 i16 u32 i32 f32 f64."),
              {"u8", "i8", "u16", "i16", "u32", "i32", "f32", "f64"});
  facts.offer(add("--endian", "ORDER", a.endian, "Headerless raw file: byte order, little (default) or big."),
              {"little", "big"});
  add("--skip", "BYTES", a.skip, "Headerless raw file: bytes before the first voxel.")->check(wholeNumberFrom(0));
  add("--spacing", "X,Y,Z", a.spacing, "Spacing in world units, of a file that has no axes.");
  add("--unit", "UNIT", a.unit, "Unit of length, of a file that states none: nm, um, mm, cm, m or another.");
  add("--grid", "NAME", a.grid, "OpenVDB: grid to read.");
  add("--series", "UID", a.series, "DICOM: series to read, if there are several.");
  add("--channel", "NAME|N", a.channel, "Channel to read, by name or number from 0, if the file has several.");
  add("--time", "N", a.time, "Time to read, from 0, if the file has several.")->check(wholeNumberFrom(0));
  add("--scale", "N", a.scale, "Resolution to read, if the file has several; 0 is the finest.")
      ->check(wholeNumberFrom(0));
  add("--flip", "AXES", a.flip, "Mirror the volume within its box along voxel axes: x, y, z or a list such as x,z.");
  add("--orient", "LETTERS", a.orient,
      "File without directions: where its voxel axes x, y, z grow in a patient, as LPS: R or L (right, left), A or P "
      "(anterior, posterior), S or I (superior, inferior).");
  // In kiln render, --up is the camera's.
  const bool taken = command.get_option_no_throw("--up") != nullptr;
  facts.offer(add(taken ? "--up-axis" : "--up-axis,--up", "AXIS", a.up,
                  "World axis of the file that points up: z (default), or y as in files of graphics."),
              {"z", "y"});
  command.add_flag("--luminance", a.luminance, "TIFF: read RGB colours as luminance.")->group(group);
  command
      .add_flag("--allow-irregular", a.allow_irregular,
                "DICOM: accept slices that are tilted, missing, unequally spaced (the median distance is used) or "
                "rescaled differently. TIFF: take all slices in the order of their names, whatever their numbers and "
                "pages.")
      ->group(group);
}

}  // namespace kiln::tool
