#include "ingest/zarr/zarr_image.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/error.h"
#include "base/file/folder.h"
#include "base/file/path_name.h"
#include "base/file/path_status.h"
#include "base/text.h"
#include "ingest/source/chosen_part.h"
#include "ingest/source/header_text.h"
#include "ingest/zarr/n5_place.h"
#include "ingest/zarr/ome_image.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Bounds for the search of a container; chunks lie below arrays, which are not entered.
constexpr int kMostDepth = 8;
constexpr std::size_t kMostFolders = 4096, kMostListed = 24;

void refuseScale(const fs::path& folder, const SourceOptions& options) {
  if (!options.scale) return;
  throw Error(ErrorCode::kUsage, folder, "--scale",
              "applies to an image of several resolutions, and this is a single array; leave it out");
}

// The axes of an array that no image describes: by the names in its header, or as xarray writes names.
std::vector<ArrayAxis> axesOf(const ZarrArray& array) {
  std::vector<std::string> names = array.axis_names;
  if (names.empty() && array.attributes) {
    const std::optional<JsonNode> xarray = array.attributes->find("_ARRAY_DIMENSIONS");
    if (xarray) names = xarray->texts();
  }
  names.resize(array.shape.size());
  std::vector<ArrayAxis> out(array.shape.size());
  for (std::size_t i = 0; i < out.size(); ++i) out[i].name = names[i];
  return out;
}

// An absolute path without "." and "..", and without a slash at the end.
fs::path wholePath(const fs::path& folder) { return withoutTrailingSlash(fs::absolute(folder).lexically_normal()); }

// A multi-scale data set of N5 is a group of arrays s0, s1, and so on; s0 is the finest. Returns the number in the
// array's name.
std::optional<std::size_t> scaleOfN5(const fs::path& folder) {
  const std::string name = folder.filename().string();
  if (zarrHeaderIn(folder).filename() != "attributes.json" || !name.starts_with('s')) return std::nullopt;
  return decimalOf<std::size_t>(name.substr(1));
}

// Opens an array of N5. The group above a scale may hold the sizes and places of its arrays.
ZarrImage ofN5Array(ZarrArray array, const SourceOptions& options) {
  const fs::path whole = wholePath(array.folder);
  const std::optional<std::size_t> scale = scaleOfN5(whole);
  std::optional<JsonNode> above;
  if (scale) above = zarrAttributes(whole.parent_path(), options.memory_bytes);
  std::vector<ArrayAxis> axes = axesOf(array);
  const bool has_scale = placeN5(array, above, scale, axes);
  ZarrImage out;
  out.volume = volumeOf(array.name(), std::move(axes), has_scale, {}, options);
  if (scale) out.volume.choice = ", " + whole.filename().string() + out.volume.choice;
  if (above) out.headers = {above->file()};
  out.headers.push_back(array.header);
  out.array = std::move(array);
  return out;
}

std::optional<ZarrImage> ofN5Scales(const fs::path& folder, const SourceOptions& options) {
  if (!scaleOfN5(folder / "s0")) return std::nullopt;
  std::optional<ZarrArray> array =
      readZarrArray(folder / fmt::format("s{}", options.scale.value_or(0)), options.memory_bytes);
  if (!array && options.scale)
    throw Error(ErrorCode::kUsage, folder, "--scale", fmt::format("there is no array s{}", *options.scale));
  if (!array) return std::nullopt;
  return ofN5Array(*std::move(array), options);
}

// The image whose scale an array is, if the group above lists the array.
std::optional<ZarrImage> imageAbove(const fs::path& folder, const SourceOptions& options) {
  const fs::path whole = wholePath(folder);
  fs::path above = whole;
  for (int level = 0; level < 2 && above.has_relative_path(); ++level) {
    above = above.parent_path();
    const std::optional<OmeImage> image = readOmeImage(above, options.memory_bytes);
    const std::optional<std::size_t> scale = image ? image->scaleOf(whole.lexically_relative(above)) : std::nullopt;
    if (scale) return image->open(*scale, options);
  }
  return std::nullopt;
}

double attributeOf(const ZarrArray& array, const char* key, double otherwise) {
  const std::optional<JsonNode> number = array.attributes ? array.attributes->findIn(key) : std::nullopt;
  return number && number->isNumber() ? number->number() : otherwise;
}

ZarrImage ofArray(ZarrArray array, const SourceOptions& options) {
  refuseScale(array.folder, options);
  if (std::optional<ZarrImage> image = imageAbove(array.folder, options)) return *std::move(image);
  if (array.format == "N5") return ofN5Array(std::move(array), options);
  ZarrImage out;
  out.volume = volumeOf(array.name(), axesOf(array), false, {}, options);
  const std::string note = noteOfScaled(attributeOf(array, "scale_factor", 1), attributeOf(array, "add_offset", 0));
  if (!note.empty()) out.volume.notes.push_back(note);
  out.headers = {array.header};
  out.array = std::move(array);
  return out;
}

std::optional<ZarrImage> ofGroup(const fs::path& folder, const SourceOptions& options) {
  if (const std::optional<OmeImage> image = readOmeImage(folder, options.memory_bytes)) {
    const std::int64_t scale = chosenScale(options, static_cast<std::int64_t>(image->scales()), folder);
    return image->open(static_cast<std::size_t>(scale), options);
  }
  return ofN5Scales(folder, options);
}

// One image or array of a container.
struct Listed {
  fs::path folder;
  std::string text;
};

class Listing {
 public:
  Listing(fs::path root, std::uint64_t memory_bytes) : root_(std::move(root)), memory_bytes_(memory_bytes) {
    visit(root_, 0);
  }
  const std::vector<Listed>& images() const { return images_; }

 private:
  void visit(const fs::path& folder, int depth) {
    if (++visited_ > kMostFolders || depth > kMostDepth) return;
    try {
      if (isLine(folder)) return;
      if (const std::optional<ZarrArray> array = readZarrArray(folder, memory_bytes_))
        return add(folder, fmt::format("({}) {}", fmt::join(array->shape, ", "), array->number.name()));
      if (const std::optional<OmeImage> image = readOmeImage(folder, memory_bytes_))
        return add(folder, fmt::format("image of {} scale{}", image->scales(), image->scales() == 1 ? "" : "s"));
      if (zarrHeaderIn(folder / "s0").filename() == "attributes.json") return add(folder, "image of N5");
    } catch (const Error& error) {
      if (error.code() == ErrorCode::kIo || error.code() == ErrorCode::kBudget) throw;
      return add(folder, "not readable");
    }
    std::vector<fs::path> below;
    forEachEntry(folder, [&](const fs::directory_entry& entry) {
      if (entry.is_directory()) below.push_back(entry.path());
      return below.size() < kMostFolders ? Walk::kGoOn : Walk::kStop;
    });
    std::sort(below.begin(), below.end());
    for (const fs::path& inner : below) visit(inner, depth + 1);
  }
  // True for an array of one axis or none, whatever its type: xarray stores coordinates beside a volume.
  bool isLine(const fs::path& folder) const {
    const fs::path header = zarrHeaderIn(folder);
    if (header.empty()) return false;
    const JsonNode json(header, memory_bytes_);
    const std::optional<JsonNode> shape = json.findIn(header.filename() == "attributes.json" ? "dimensions" : "shape");
    return shape && shape->isList() && shape->items().size() < 2;
  }
  void add(const fs::path& folder, const std::string& what) {
    images_.push_back({folder, fmt::format("{} {}", inQuotes(folder.lexically_relative(root_).string()), what)});
  }

  fs::path root_;
  std::uint64_t memory_bytes_;
  std::vector<Listed> images_;
  std::size_t visited_ = 0;
};

ZarrImage onlyImageBelow(const fs::path& folder, const SourceOptions& options) {
  const std::vector<Listed> images = Listing(folder, options.memory_bytes).images();
  if (images.empty())
    throw Error(ErrorCode::kUnsupported, folder, "", "is a Zarr or N5 group without an array of two axes or more");
  if (images.size() == 1) {
    ZarrImage out = openZarrImage(images.front().folder, options);
    out.volume.choice += fmt::format(", {}", images.front().folder.lexically_relative(folder).string());
    out.volume.notes.push_back("took " + images.front().text + ", the only image");
    return out;
  }
  std::string list;
  for (std::size_t i = 0; i < std::min(images.size(), kMostListed); ++i) list += (i == 0 ? "" : "; ") + images[i].text;
  if (images.size() > kMostListed) list += fmt::format("; and {} more", images.size() - kMostListed);
  throw Error(ErrorCode::kUsage, folder, "",
              fmt::format("holds {} images or arrays: {}; name the folder of one, as {}", images.size(), list,
                          images.front().folder.string()));
}

}  // namespace

ZarrImage openZarrImage(const fs::path& folder, const SourceOptions& options) {
  if (std::optional<ZarrArray> array = readZarrArray(folder, options.memory_bytes))
    return ofArray(*std::move(array), options);
  if (std::optional<ZarrImage> image = ofGroup(folder, options)) return *std::move(image);
  refusePlate(folder, options.memory_bytes);
  return onlyImageBelow(folder, options);
}

}  // namespace kiln
