#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <system_error>
#include <utility>

#include "base/file/file.h"
#include "base/file/path_status.h"
#include "base/memory/memory.h"
#include "commands.h"
#include "examples.h"
#include "foreign_store.h"
#include "grid/declared_look.h"
#include "image/file/image_file.h"
#include "ingest/open_source.h"
#include "ingest/source/placement.h"
#include "job/job_names.h"
#include "picture_job.h"
#include "ranks/split_store.h"
#include "say.h"
#include "scene/transfer/label_styles.h"
#include "store/manifest/json_text.h"
#include "store/manifest/volume_json.h"
#include "store/store_reader.h"
#include "volume_values.h"

namespace kiln::tool {
namespace fs = std::filesystem;
namespace {

const char* className(VolumeClass volume_class) {
  switch (volume_class) {
    case VolumeClass::kFog:
      return "fog";
    case VolumeClass::kLevelSet:
      return "level set";
    case VolumeClass::kLabels:
      return "labels";
    case VolumeClass::kUnknown:
      break;
  }
  return "unknown";
}

// Prints the first labels; a volume may have thousands.
void printLabels(const std::vector<LabelCount>& labels) {
  constexpr std::size_t kMost = 64;
  say("labels       {} that {} voxels\n", labels.size(), labels.size() == 1 ? "has" : "have");
  for (std::size_t i = 0; i < std::min(labels.size(), kMost); ++i)
    say("             {:>8.0f}  {} voxel{}\n", labels[i].label, labels[i].voxels, labels[i].voxels == 1 ? "" : "s");
  if (labels.size() > kMost)
    say("             and {} more, which kiln info --json has in its histogram\n", labels.size() - kMost);
}

const char* frameName(PatientFrame frame) {
  switch (frame) {
    case PatientFrame::kRas:
      return "RAS (+x right, +y anterior, +z superior)";
    case PatientFrame::kLps:
      return "LPS (+x left, +y posterior, +z superior)";
    case PatientFrame::kUnknown:
      break;
  }
  return "unknown";
}

// The size of the voxels in memory. unit: bytes.
std::uint64_t bytesOf(const VolumeGeometry& geometry, VoxelType type) {
  return static_cast<std::uint64_t>(geometry.dims.count()) * sizeOf(type);
}

// Sizes of the store's files, and numbers of bricks without a file.
struct Storage {
  std::uint64_t raw_bytes = 0;                 // size of level 0 in memory
  std::uint64_t disk_bytes = 0;                // size of all files
  std::vector<std::uint64_t> constant_bricks;  // a level each

  double ratio() const { return static_cast<double>(disk_bytes) / static_cast<double>(raw_bytes); }
};

Storage storageOf(const StoreReader& store) {
  const Manifest& m = store.manifest();
  Storage out;
  out.raw_bytes = bytesOf(m.geometry(), m.type);
  out.disk_bytes = File(store.path() / "manifest.json").size() + m.index_bytes;
  store.requireUnchanged();
  for (const LevelInfo& level : m.levels) {
    out.disk_bytes += level.stored_bytes;
    out.constant_bricks.push_back(static_cast<std::uint64_t>(level.bricks.count()) - level.stored_bricks);
  }
  return out;
}

void printLevels(const Manifest& m, const Storage& storage) {
  for (std::size_t i = 0; i < m.levels.size(); ++i) {
    const LevelInfo& level = m.levels[i];
    const Extent3& dims = level.geometry.dims;
    say("level {:<6} {} x {} x {} voxels, {} bricks of {}^3: {} stored in {}, {} constant\n", i, dims.x, dims.y, dims.z,
        level.bricks.count(), m.brick_size, level.stored_bricks, formatBytes(level.stored_bytes),
        storage.constant_bricks[i]);
  }
  say("on disk      {}, {:.1f} % of the {} of its voxels in memory\n", formatBytes(storage.disk_bytes),
      100 * storage.ratio(), formatBytes(storage.raw_bytes));
}

// Returns the manifest with facts derived from the manifest and the index.
std::string textForPrograms(const StoreReader& store) {
  auto out = nlohmann::ordered_json::parse(readTextFile(store.path() / "manifest.json"));
  const Storage storage = storageOf(store);
  out["storage"] = {{"rawBytes", storage.raw_bytes},
                    {"diskBytes", storage.disk_bytes},
                    {"ratio", storage.ratio()},
                    {"constantBricks", storage.constant_bricks}};
  return out.dump(1) + "\n";
}

void printGeometry(const VolumeGeometry& g, VoxelType type) {
  const glm::dvec3 spacing = g.spacing();
  const std::string unit = g.unit.empty() ? "world units" : g.unit;
  say("dimensions   {} x {} x {} voxels of {} ({})\n", g.dims.x, g.dims.y, g.dims.z, nameOf(type),
      formatBytes(bytesOf(g, type)));
  say("spacing      {:.6g} x {:.6g} x {:.6g} {}\n", spacing.x, spacing.y, spacing.z, unit);
  say("affine       ");
  for (int row = 0; row < 3; ++row) {
    say("{}[{:.6g} {:.6g} {:.6g} {:.6g}]\n", row == 0 ? "" : "             ", g.world_from_index[0][row],
        g.world_from_index[1][row], g.world_from_index[2][row], g.world_from_index[3][row]);
  }
  say("patient      {}\n", frameName(g.frame));
}

void printValues(const VolumeValues& values) {
  const Manifest& m = values.manifest;
  if (m.range.empty()) {
    say("values       none but NaN\n");
  } else {
    say("values       {:.9g} to {:.9g}, background {:.6g}, class {}\n", m.range.lo, m.range.hi, m.background,
        className(m.volume_class));
  }
  if (m.look.ramp)
    say("window       {:.9g} to {:.9g} in {}, by the source's author\n", m.look.ramp->begin, m.look.ramp->end,
        textOf(m.look.ramp->color));
  if (!m.look.labels.empty()) say("colours      of {} labels by the source's author\n", m.look.labels.size());
  if (m.nan_count > 0) say("NaN          {} voxels\n", m.nan_count);
  if (const auto labels = labelsOf(m))
    printLabels(*labels);
  else
    sayHistogram(values);
}

void printForPeople(const StoreReader& store, Progress& progress) {
  const Manifest& m = store.manifest();
  const Storage storage = storageOf(store);
  say("store        {} (format {})\n", store.path().string(), m.format);
  if (const auto part = findStorePart(store.path(), progress))
    say("part         voxels {},{},{} to {},{},{}, made by kiln split; the lines below are of the whole store\n",
        part->lo.x, part->lo.y, part->lo.z, part->hi.x, part->hi.y, part->hi.z);
  printGeometry(m.geometry(), m.type);
  printValues({m, "", 0});
  printLevels(m, storage);
  say("codec        {}, blosc\n", m.container_version);
  // A directory of slices comes first, then its slices.
  const std::vector<std::string>& files = m.source.files;
  const std::size_t named = files.size() > 3 ? 1 : files.size();
  for (std::size_t i = 0; i < named; ++i) say("source       {} ({})\n", files[i], m.source.format);
  if (named < files.size()) say("             and {} files in it\n", files.size() - named);
  if (!m.source.command.empty()) say("made by      {}\n", m.source.command);
  if (!m.source.time.empty()) say("made at      {}\n", m.source.time);
}

// Number of files: a folder is the first name of its files.
std::size_t filesIn(const SourceInfo& info) {
  return info.files.size() - (!info.files.empty() && isFolder(info.files.front()) ? 1 : 0);
}

// Prints the header of a volume file.
void printHeader(const std::string& path, const SourceInfo& info) {
  say("volume       {} ({}{})\n", path, info.format, filesIn(info) > 1 ? fmt::format(", {} files", filesIn(info)) : "");
  printGeometry(info.geometry, info.type);
  for (const std::string& note : info.notes) say("note         {}\n", note);
  if (const std::string note = orientationNote(info); !note.empty()) say("note         {}\n", note);
}

// Returns the header and the values of a volume file for programs, with the keys of a manifest.
std::string sourceForPrograms(const SourceInfo& info, const VolumeValues& values) {
  nlohmann::ordered_json files = nlohmann::ordered_json::array();
  for (const fs::path& file : info.files) files.push_back(utf8OfName(file.string()));
  nlohmann::ordered_json out = volumeJson(values.manifest);
  out.update({{"sample", {{"voxels", values.sampled}, {"text", values.counted}}},
              {"source", {{"format", info.format}, {"files", files}, {"notes", info.notes}}},
              {"storage", {{"rawBytes", bytesOf(info.geometry, info.type)}}}});
  return jsonText(std::move(out), 1) + "\n";
}

// Prints the size, the compression and the channels of a picture.
void printLayout(const PixelLayout& layout) {
  say("pixels       {} x {}", layout.width, layout.height);
  if (layout.png_bits > 0) return say(" of {} bits a channel\n", layout.png_bits);
  if (layout.x != 0 || layout.y != 0) say(" from {}, {}", layout.x, layout.y);
  say("{}, compression {}\n", layout.deep ? ", deep" : "", layout.compression);
  std::string channels;
  for (const auto& [name, type] : layout.channels)
    channels += fmt::format("{}{} {}", channels.empty() ? "" : ", ", name, type);
  say("channels     {}\n", channels);
}

// Prints the texts of a picture's header, the job last because of its length.
void printPicture(const fs::path& path, std::uint64_t memory_bytes) {
  std::map<std::string, std::string> texts = readImageText(path, memory_bytes);
  const PixelLayout layout = readPixelLayout(path);
  const std::string job = std::exchange(texts[ImageMetadata::kJob], {});
  say("picture      {}\n", path.string());
  printLayout(layout);
  for (const auto& [name, text] : texts) {
    if (text.empty()) continue;
    const bool several_lines = text.find('\n') != std::string::npos;
    say("{:<12} ", name);
    sayLines((several_lines ? "\n" : "") + text + "\n");
  }
  if (!job.empty()) sayLines(fmt::format("{:<12}\n{}\n", ImageMetadata::kJob, job));
}

// Returns the job of a picture as JSON, which `kiln render` reads from a file.
std::string jobForPrograms(const fs::path& path, std::uint64_t memory_bytes) {
  const std::optional<std::string> job = jobTextOf(path, memory_bytes);
  if (!job)
    throw Error(ErrorCode::kUnsupported, path, ImageMetadata::kJob,
                "is not there: a picture that Kiln drew has its job in it");
  return *job + "\n";
}

// Prints the header first, as the values of a damaged file are an error.
void printSource(const ForeignVolume& volume, std::uint64_t memory_bytes, bool json, Context& context) {
  const std::unique_ptr<VolumeSource> source = openedWithin(memory_bytes, volume);
  const auto values = [&] { return valuesOf(volume, *source, memory_bytes, context.progress); };
  if (json) return sayJson(sourceForPrograms(source->info(), values()));
  printHeader(volume.input.string(), source->info());
  printValues(values());
  say("             kiln render draws the file, kiln convert makes a store of it\n");
}

}  // namespace

void addInfo(CLI::App& app, Context& context) {
  auto path = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  auto memory = std::make_shared<std::string>(kDefaultMemory);
  auto source = std::make_shared<ForeignArguments>();
  CLI::App* command = app.add_subcommand("info", "Show what a store or volume file holds, or how a picture was made.");
  command->add_option("STORE", *path, "The store, a volume file, or a picture that Kiln drew.")->required();
  command->add_flag("--json", *json,
                    "For programs: a store's manifest, and what it takes on disk; the header of a volume file, and "
                    "values of a sample; a picture's job, which kiln render draws again.");
  addMemory(*command, *memory, "the index of a store, a volume file, or the texts of a picture")->capture_default_str();
  addForeignArguments(*command, context.facts, *source);
  addExamples(*command, {"kiln info head.kiln", "kiln info scan.nrrd --json", "kiln info face.png"});
  command->callback([path, json, memory, source, &context] {
    context.action = [path, json, memory, source, &context] {
      const std::uint64_t memory_bytes = parseBytes(*memory, "--memory");
      if (namesVolumeFile(*path, *source)) return printSource(source->volume(*path), memory_bytes, *json, context);
      refuseVolumeFile(*path, "a store or a picture");
      std::error_code ignored;
      if (fs::is_regular_file(*path, ignored)) {
        if (!isPicture(*path)) openSource(*path, {});  // throws: the file is no volume either
        source->requireNoneForPicture(*path);
        if (*json)
          sayJson(jobForPrograms(*path, memory_bytes));
        else
          printPicture(*path, memory_bytes);
        return;
      }
      source->requireNoneForStore(*path);
      const StoreReader store(*path, memory_bytes);  // checks before anything is printed
      if (*json) {
        sayJson(textForPrograms(store));
      } else {
        printForPeople(store, context.progress);
      }
    };
  });
}

}  // namespace kiln::tool
