#include "volume_values.h"

#include <system_error>

#include "convert/store_of_source.h"
#include "convert/volume_sample.h"
#include "frame/slice.h"
#include "histogram_text.h"
#include "ingest/open_source.h"
#include "ingest/source/formats.h"
#include "ingest/volume_format.h"
#include "say.h"
#include "scene/transfer/display_map.h"
#include "scene/transfer/preset_ranges.h"
#include "scene/transfer/presets.h"
#include "store/manifest/read_manifest.h"
#include "store/store_reader.h"

namespace kiln::tool {
namespace fs = std::filesystem;
namespace {

std::string countedText(const VolumeSample& sample) {
  const auto all = static_cast<std::uint64_t>(sample.manifest.geometry().dims.count());
  if (sample.voxels == all) return fmt::format("all {} voxels", all);
  if (sample.from_begin) return fmt::format("the first {} of {} voxels of a compressed stream", sample.voxels, all);
  return fmt::format("{} of {} voxels", sample.voxels, all);
}

void sayWindow(const Window& window, const char* shows) {
  say("window       {:<24} centre,width: {}\n", windowText(window), shows);
}

Window windowOver(const ValueRange& range) { return {0.5 * (range.lo + range.hi), range.hi - range.lo}; }

}  // namespace

bool namesVolumeFile(const fs::path& path, const SourceWords& arguments) {
  if (namesPhantom(path) || !arguments.dims.empty()) return true;
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return !isForStoreReader(path);
  const VolumeFormat format = volumeFormatOf(path);
  return !format.name.empty() && format.read;
}

VolumeValues valuesOf(const ForeignVolume& volume, VolumeSource& source, std::uint64_t memory_bytes,
                      Progress& progress) {
  if (const std::optional<fs::path> store = madeStoreOf(volume, source.info(), memory_bytes))
    return {readManifest(*store), fmt::format("all voxels, by the store {}", store->string()), 0};
  VolumeSample sample = sampleOf(source, memory_bytes, progress);
  std::string counted = countedText(sample);
  return {std::move(sample.manifest), std::move(counted), sample.voxels};
}

void sayHistogram(const VolumeValues& values) {
  const std::string histogram =
      histogramText(values.manifest.histogram, !isFloating(values.manifest.type), "             ");
  if (histogram.empty()) return;
  const std::string of = values.counted.empty() ? "" : "of " + values.counted + "; ";
  sayLines("histogram    " + of + "length of a bar: logarithm of the count\n" + histogram);
}

void sayWindows(const Manifest& manifest) {
  if (manifest.histogram.counts.empty()) return;
  sayWindow(defaultWindow(manifest.histogram), "the middle 99 % of the values, as kiln slice shows");
  sayWindow(windowOver(colorMapRange(manifest)), "what is not empty, as colour maps show");
  // Values as low as air's are Hounsfield units, as for the ct- presets.
  constexpr double kBelowFat = -200, kBone = 300;
  const ValueRange range = usableRange(manifest);
  if (manifest.volume_class != VolumeClass::kUnknown || range.lo >= kBelowFat || range.hi < kBone) return;
  sayWindow({40, 400}, "soft tissue, if the values are Hounsfield units");
  sayWindow({40, 80}, "brain");
  sayWindow({-600, 1500}, "lung");
  sayWindow({500, 2000}, "bone");
}

}  // namespace kiln::tool
