#include "ingest/zarr/ome_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/error.h"
#include "base/file/path_name.h"
#include "base/file/path_status.h"
#include "grid/declared_look.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Version 0.5 keeps its attributes below "ome".
std::optional<JsonNode> omeAttributes(const fs::path& group, std::uint64_t memory_bytes) {
  const std::optional<JsonNode> attributes = zarrAttributes(group, memory_bytes);
  if (!attributes || !attributes->isObject()) return std::nullopt;
  const std::optional<JsonNode> ome = attributes->find("ome");
  return ome && ome->isObject() ? ome : attributes;
}

void requireCount(const JsonNode& list, std::size_t found, std::size_t expected) {
  if (found != expected) list.fail(fmt::format("must have a number for each of {} axes", expected));
}

// Applies a list of transformations in order. Returns true if there is a scale among them.
bool transform(const JsonNode& list, std::vector<ArrayAxis>& axes) {
  bool scaled = false;
  for (const JsonNode& step : list.items(64)) {
    const std::string type = step.at("type").text();
    if (type == "identity") continue;
    if (type != "scale" && type != "translation")
      step.unsupported(fmt::format("the transformation {} is not read; write scale and translation", inQuotes(type)));
    const JsonNode values = step.at(type);
    const std::vector<double> numbers = values.numbers();
    requireCount(values, numbers.size(), axes.size());
    for (std::size_t i = 0; i < axes.size(); ++i) {
      if (type == "translation") {
        axes[i].translation += numbers[i];
      } else {
        axes[i].scale *= numbers[i];
        axes[i].translation *= numbers[i];
      }
    }
    scaled = scaled || type == "scale";
  }
  return scaled;
}

// Without "." and "..", and without a slash at the end.
fs::path plainPath(const fs::path& path) { return withoutTrailingSlash(path.lexically_normal()); }

ArrayAxis axisOf(const JsonNode& json) {
  ArrayAxis out;
  // Version 0.3 has names alone.
  if (json.isText()) {
    out.name = json.text();
    return out;
  }
  out.name = json.at("name").text();
  const std::optional<JsonNode> type = json.find("type"), unit = json.find("unit"),
                                orientation = json.find("orientation");
  if (type && type->text() == "channel") out.name = 'c';
  if (type && type->text() == "time") out.name = 't';
  if (unit) out.unit = unit->text();
  if (orientation) {
    const std::optional<JsonNode> value = orientation->isObject() ? orientation->find("value") : orientation;
    if (value && value->isText()) out.orientation = value->text();
  }
  return out;
}

std::optional<JsonNode> objectAt(const JsonNode& json, const char* key) {
  const std::optional<JsonNode> found = json.findIn(key);
  return found && found->isObject() ? found : std::nullopt;
}

std::vector<JsonNode> listAt(const JsonNode& json, const char* key) {
  const std::optional<JsonNode> found = json.findIn(key);
  return found && found->isList() ? found->items() : std::vector<JsonNode>();
}

std::string textAt(const JsonNode& json, const char* key) {
  const std::optional<JsonNode> found = json.findIn(key);
  return found && found->isText() ? found->text() : "";
}

// The path of the first entry of a list; empty without one.
fs::path firstPathIn(const JsonNode& json, const char* key) {
  const std::vector<JsonNode> list = listAt(json, key);
  return list.empty() ? "" : textAt(list.front(), "path");
}

// The window and the colour in which OMERO shows a channel; nothing for curves, inverted windows, and windows whose
// ends are no values: drawing computes in floats of 32 bits.
std::optional<DeclaredLook::Ramp> rampIn(const JsonNode& channel) {
  const std::optional<JsonNode> window = objectAt(channel, "window");
  const std::string family = textAt(channel, "family");
  if (!window || !(family.empty() || family == "linear")) return std::nullopt;
  const std::optional<JsonNode> begin = window->find("start"), end = window->find("end"),
                                inverted = channel.find("inverted");
  if (!begin || !end || !begin->isNumber() || !end->isNumber()) return std::nullopt;
  if (inverted && inverted->isTruth() && inverted->truth()) return std::nullopt;
  const DeclaredLook::Ramp out = {begin->number(), end->number(),
                                  displayColorOf(textAt(channel, "color")).value_or(DisplayColor())};
  constexpr double kLargest = std::numeric_limits<float>::max() / 2;
  const bool drawable = out.begin < out.end && std::abs(out.begin) <= kLargest && std::abs(out.end) <= kLargest;
  return drawable ? std::optional(out) : std::nullopt;
}

// {"label-value": 3, "rgba": [255, 128, 0, 255]}.
std::optional<DeclaredLook::Label> labelIn(const JsonNode& color) {
  const std::optional<JsonNode> label = color.findIn("label-value");
  const std::vector<JsonNode> rgba = listAt(color, "rgba");
  if (!label || !label->isNumber() || rgba.size() != 4) return std::nullopt;
  std::array<std::uint8_t, 4> bytes{};
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    const double number = rgba[i].isNumber() ? rgba[i].number() : -1;
    if (!(number >= 0 && number <= 255)) return std::nullopt;
    bytes[i] = static_cast<std::uint8_t>(number);
  }
  const double number = label->number();
  if (number != std::floor(number) || std::abs(number) > UINT32_MAX) return std::nullopt;
  return DeclaredLook::Label{static_cast<std::int64_t>(number), {bytes[0], bytes[1], bytes[2], bytes[3]}};
}

}  // namespace

std::optional<OmeImage> readOmeImage(const fs::path& group, std::uint64_t memory_bytes) {
  const std::optional<JsonNode> ome = omeAttributes(group, memory_bytes);
  const std::optional<JsonNode> multiscales = ome ? ome->find("multiscales") : std::nullopt;
  if (!multiscales) return std::nullopt;
  const std::vector<JsonNode> images = multiscales->items(1024);
  // Programs around N5 use the key for a list without axes, and describe each array by attributes.
  const bool of_n5 = multiscales->file().filename() == "attributes.json";
  if (images.empty() || (of_n5 && !images.front().find("axes"))) return std::nullopt;
  return OmeImage(group, *ome, images.front(), images.size() > 1);
}

void refusePlate(const fs::path& group, std::uint64_t memory_bytes) {
  const std::optional<JsonNode> ome = omeAttributes(group, memory_bytes),
                                plate = ome ? ome->find("plate") : std::nullopt;
  if (!plate) return;
  const fs::path well = firstPathIn(*plate, "wells");
  const std::optional<JsonNode> of_well = well.empty() ? std::nullopt : omeAttributes(group / well, memory_bytes),
                                images = of_well ? of_well->find("well") : std::nullopt;
  const fs::path image = images ? firstPathIn(*images, "images") : "";
  throw Error(ErrorCode::kUnsupported, group, "",
              "is a plate of many wells, which is not read as a volume; name the folder of one image" +
                  (image.empty() ? "" : ", as " + (group / well / image).string()));
}

std::size_t OmeImage::scales() const {
  const JsonNode datasets = multiscale_.at("datasets");
  const std::size_t count = datasets.items().size();
  if (count == 0) datasets.fail("must list an array");
  return count;
}

// A path must not leave the container.
fs::path OmeImage::arrayOf(const JsonNode& dataset) const {
  const JsonNode path = dataset.at("path");
  const fs::path relative = plainPath(path.text());
  const bool leaves = relative.is_absolute() || (!relative.empty() && *relative.begin() == "..");
  if (relative.empty() || leaves || path.text().find('\0') != std::string::npos)
    path.fail("must be a path inside the container");
  return group_ / relative;
}

std::optional<std::size_t> OmeImage::scaleOf(const fs::path& path) const {
  const std::vector<JsonNode> datasets = multiscale_.at("datasets").items();
  for (std::size_t i = 0; i < datasets.size(); ++i)
    if (plainPath(datasets[i].at("path").text()) == path) return i;
  return std::nullopt;
}

std::vector<ArrayAxis> OmeImage::axes(std::size_t count) const {
  std::vector<ArrayAxis> out;
  if (const std::optional<JsonNode> axes = multiscale_.find("axes")) {
    for (const JsonNode& axis : axes->items(32)) out.push_back(axisOf(axis));
    requireCount(*axes, out.size(), count);
  } else {
    // Versions 0.1 and 0.2 have these axes and no others.
    for (const char name : {'t', 'c', 'z', 'y', 'x'}) out.emplace_back().name = name;
    if (count != out.size()) multiscale_.fail("\"axes\" is missing, which arrays of other than 5 axes need");
  }
  return out;
}

// Looks are left out, not refused, if they are not as expected: OMERO's keys are no part of the standard.
std::vector<JsonNode> OmeImage::omeroChannels() const {
  const std::optional<JsonNode> omero = objectAt(ome_, "omero");
  return omero ? listAt(*omero, "channels") : std::vector<JsonNode>();
}

std::vector<std::string> OmeImage::channels() const {
  std::vector<std::string> out;
  for (const JsonNode& channel : omeroChannels()) out.push_back(textAt(channel, "label"));
  return out;
}

void OmeImage::addLook(ArrayVolume& volume) const {
  if (const std::optional<JsonNode> labels = objectAt(ome_, "image-label")) {
    for (const JsonNode& color : listAt(*labels, "colors"))
      if (const auto label = labelIn(color)) volume.look.labels.push_back(*label);
    sortDeclared(volume.look.labels);
    return;
  }
  const std::vector<JsonNode> channels = omeroChannels();
  const auto index = static_cast<std::size_t>(volume.channel);
  if (index < channels.size()) volume.look.ramp = rampIn(channels[index]);
}

ZarrImage OmeImage::open(std::size_t scale, const SourceOptions& options) const {
  const JsonNode dataset = multiscale_.at("datasets").items()[scale];
  const fs::path folder = arrayOf(dataset);
  std::optional<ZarrArray> array = readZarrArray(folder, options.memory_bytes);
  if (!array) throw Error(ErrorCode::kFormat, folder, "", "is no array, but the image lists it as a scale");
  std::vector<ArrayAxis> image_axes = axes(array->shape.size());
  bool has_scale = false;
  if (const auto list = dataset.find("coordinateTransformations")) has_scale |= transform(*list, image_axes);
  if (const auto list = multiscale_.find("coordinateTransformations")) has_scale |= transform(*list, image_axes);
  ZarrImage out;
  out.volume = volumeOf(array->name(), std::move(image_axes), has_scale, channels(), options);
  out.volume.choice = fmt::format(", OME-Zarr, array {}", inQuotes(dataset.at("path").text())) + out.volume.choice;
  if (ome_.find("image-label")) {
    if (isFloating(array->number.voxelType()))
      out.volume.notes.push_back("states labels, but its values are fractions; read as amounts");
    else
      out.volume.volume_class = VolumeClass::kLabels;
  }
  addLook(out.volume);
  if (has_others_) out.volume.notes.push_back("the group describes several images; took the first");
  if (isFolder(group_ / "labels"))
    out.volume.notes.push_back("has labels in its folder 'labels', which is a volume of its own");
  out.headers = {multiscale_.file(), array->header};
  out.array = *std::move(array);
  return out;
}

}  // namespace kiln
