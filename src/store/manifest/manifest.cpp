// manifest.json: every key is written, every key is required, and no further key is allowed. The checksum covers the
// text with the 32 digits of the checksum itself read as zeros.
#include "store/manifest/manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "base/error.h"
#include "base/text.h"
#include "grid/declared_look.h"
#include "grid/pyramid.h"
#include "grid/shared_world.h"
#include "store/manifest/json_text.h"
#include "store/manifest/store_files.h"
#include "store/manifest/volume_json.h"
#include "store/ranges/minmax_octree.h"

namespace kiln {
namespace {

using Json = nlohmann::ordered_json;  // keys are written in this order, and are sought one by one
using Parsed = nlohmann::json;

constexpr const char* kChecksumKey = "\"checksum\": \"";
constexpr std::size_t kDigits = 32;
constexpr std::int64_t kLargestDimension = std::numeric_limits<std::int32_t>::max();

constexpr std::pair<VolumeClass, const char*> kClassNames[] = {{VolumeClass::kUnknown, "unknown"},
                                                               {VolumeClass::kFog, "fog"},
                                                               {VolumeClass::kLevelSet, "levelset"},
                                                               {VolumeClass::kLabels, "labels"}};
constexpr std::pair<PatientFrame, const char*> kFrameNames[] = {
    {PatientFrame::kUnknown, "unknown"}, {PatientFrame::kRas, "RAS"}, {PatientFrame::kLps, "LPS"}};

template <class T, std::size_t N>
const char* nameIn(const std::pair<T, const char*> (&names)[N], T value) {
  for (const auto& [known, name] : names) {
    if (known == value) return name;
  }
  return "";
}

Json triple(const Extent3& v) { return Json::array({v.x, v.y, v.z}); }

constexpr const char* kStoreRemedy = "; restore this file of the store, or convert the source again";

// Reads the values of a JSON object by key, and reports keys that were never read.
class Reader {
 public:
  Reader(const Parsed& object, std::string place, const std::filesystem::path& path)
      : object_(object), place_(std::move(place)), path_(path) {
    if (!object.is_object()) fail("", "expected an object");
  }

  const Parsed& get(const char* key) {
    seen_.emplace_back(key);
    const auto it = object_.find(key);
    if (it == object_.end()) fail(key, "is missing");
    return *it;
  }
  bool has(const char* key) const { return object_.contains(key); }

  template <class T>
  T value(const char* key) {
    const Parsed& found = get(key);
    try {
      return found.get<T>();
    } catch (const nlohmann::json::exception&) {
      fail(key, std::is_same_v<T, std::string> ? "expected a text" : "expected a list of texts");
    }
  }
  std::int64_t integer(const char* key, std::int64_t lo, std::int64_t hi) {
    const Parsed& found = get(key);
    const std::int64_t n = found.is_number_integer() ? found.get<std::int64_t>() : 0;
    if (!found.is_number_integer() || n < lo || n > hi)
      fail(key, fmt::format("expected a whole number from {} to {}", lo, hi));
    return n;
  }
  std::uint64_t count(const char* key) {
    return static_cast<std::uint64_t>(integer(key, 0, std::numeric_limits<std::int64_t>::max()));
  }
  double number(const char* key) {
    const Parsed& found = get(key);
    if (found.is_number()) return found.get<double>();
    if (found == "nan") return std::numeric_limits<double>::quiet_NaN();
    if (found == "inf" || found == "-inf") return (found == "inf" ? 1 : -1) * std::numeric_limits<double>::infinity();
    fail(key, "expected a number");
  }
  Extent3 extent(const char* key) {
    const Parsed& found = get(key);
    Extent3 out;
    std::int64_t* const into[3] = {&out.x, &out.y, &out.z};
    if (!found.is_array() || found.size() != 3) fail(key, "expected three whole numbers");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (!found[axis].is_number_integer()) fail(key, "expected three whole numbers");
      *into[axis] = found[axis].get<std::int64_t>();
      if (*into[axis] < 1 || *into[axis] > kLargestDimension)
        fail(key, fmt::format("expected three whole numbers from 1 to {}", kLargestDimension));
    }
    return out;
  }
  glm::dmat4 matrix(const char* key) {
    const Parsed& found = get(key);
    glm::dmat4 out(1.0);
    if (!found.is_array() || found.size() != 16) fail(key, "expected 16 numbers");
    for (int i = 0; i < 16; ++i) {
      const Parsed& entry = found[static_cast<std::size_t>(i)];
      if (!entry.is_number()) fail(key, "expected 16 numbers");
      out[i % 4][i / 4] = entry.get<double>();
    }
    return out;
  }
  template <class T, std::size_t N>
  T named(const char* key, const std::pair<T, const char*> (&names)[N]) {
    const std::string name = value<std::string>(key);
    for (const auto& [known, known_name] : names) {
      if (name == known_name) return known;
    }
    fail(key, "is none of the known names");
  }
  template <class T>
  std::vector<T> wholeNumbers(const char* key, std::optional<std::size_t> count = {}) {
    const Parsed& found = get(key);
    const auto legal = [](const Parsed& n) {
      return std::is_signed_v<T>
                 ? n.is_number_integer() && (!n.is_number_unsigned() || n.get<std::uint64_t>() <= INT64_MAX)
                 : n.is_number_unsigned();
    };
    if (!found.is_array() || !std::all_of(found.begin(), found.end(), legal) ||
        found.size() != count.value_or(found.size()))
      fail(key,
           count ? fmt::format("expected {} whole numbers", *count) : "expected a list of whole numbers from 0 on");
    return found.get<std::vector<T>>();
  }
  void same(const char* key, std::string_view expected) {
    if (value<std::string>(key) != expected) fail(key, fmt::format("expected \"{}\"", expected));
  }
  Hash128 checksum(const char* key) {
    const std::string digits = value<std::string>(key);
    try {
      return hashFromHex(digits);
    } catch (const Error& error) {
      fail(key, error.what());
    }
  }
  DisplayColor color(const char* key) {
    const std::optional<DisplayColor> out = displayColorOf(value<std::string>(key));
    if (!out) fail(key, "expected #rrggbb or #rrggbbaa");
    return *out;
  }
  void finish() const {
    for (const auto& [key, unused] : object_.items()) {
      if (std::find(seen_.begin(), seen_.end(), key) == seen_.end())
        fail(key.c_str(), "is not a key of a store's manifest");
    }
  }
  [[noreturn]] void fail(const char* key, const std::string& what) const {
    constexpr std::size_t kMost = 60;
    const auto at = object_.is_object() ? object_.find(key) : object_.end();
    std::string found = object_.is_object() ? (at == object_.end() ? "" : at->dump()) : object_.dump();
    if (found.size() > kMost) found = found.substr(0, kMost) + "...";
    if (!found.empty()) found = " (found " + found + ")";
    throw Error(ErrorCode::kFormat, path_, place_ + key, what + found + kStoreRemedy);
  }

 private:
  const Parsed& object_;
  std::string place_;
  const std::filesystem::path& path_;
  std::vector<std::string> seen_;
};

Json sourceJson(const Provenance& source, int format) {
  Json out = {{"format", source.format},
              {"files", source.files},
              {"command", source.command},
              {"time", source.time},
              {"kiln", KILN_VERSION}};
  if (format >= 4) out["state"] = source.state;
  if (source.vdb) {
    out["grid"] = source.vdb->grid_name;
    const VoxelCoord& origin = source.vdb->index_origin;
    out["indexOrigin"] = Json::array({origin.x, origin.y, origin.z});
    out["gridAffine"] = rowsOf(source.vdb->world_from_grid);
  }
  return out;
}

Provenance readSource(Reader source, int format) {
  Provenance out;
  out.format = source.value<std::string>("format");
  out.files = source.value<std::vector<std::string>>("files");
  out.command = source.value<std::string>("command");
  out.time = source.value<std::string>("time");
  source.value<std::string>("kiln");
  if (format >= 4) out.state = source.value<std::string>("state");
  if (source.has("grid")) {
    VdbOrigin vdb;
    vdb.grid_name = source.value<std::string>("grid");
    const auto origin = source.wholeNumbers<std::int64_t>("indexOrigin", 3);
    vdb.index_origin = {origin[0], origin[1], origin[2]};
    vdb.world_from_grid = source.matrix("gridAffine");
    out.vdb = vdb;
  }
  source.finish();
  return out;
}

Json lookJson(const DeclaredLook& look) {
  Json out = Json::object();
  if (look.ramp)
    out["ramp"] = {{"begin", look.ramp->begin}, {"end", look.ramp->end}, {"color", textOf(look.ramp->color)}};
  Json labels = Json::object();
  auto& pairs = labels.get_ref<Json::object_t&>();  // the labels differ, so that none has to be sought
  for (const DeclaredLook::Label& label : look.labels)
    pairs.emplace_back(std::to_string(label.label), textOf(label.color));
  if (!labels.empty()) out["labels"] = std::move(labels);
  return out;
}

DeclaredLook readLook(Reader look, const std::filesystem::path& path) {
  DeclaredLook out;
  if (look.has("ramp")) {
    Reader ramp(look.get("ramp"), "look.ramp.", path);
    out.ramp = {ramp.number("begin"), ramp.number("end"), ramp.color("color")};
    if (!std::isfinite(out.ramp->begin) || !std::isfinite(out.ramp->end) || out.ramp->begin >= out.ramp->end)
      ramp.fail("end", "expected a number above begin");
    ramp.finish();
  }
  if (look.has("labels")) {
    const Parsed& written = look.get("labels");
    Reader labels(written, "look.labels.", path);
    for (const auto& [key, unused] : written.items()) {
      const std::optional<std::int64_t> label = numberOf<std::int64_t>(key);
      if (!label) labels.fail(key.c_str(), "expected a whole number as key");
      out.labels.push_back({*label, labels.color(key.c_str())});
    }
    sortDeclared(out.labels);
  }
  look.finish();
  return out;
}

LevelInfo readLevel(Reader level, const VolumeGeometry& frame_and_unit, std::int64_t brick_size) {
  LevelInfo out;
  out.geometry = frame_and_unit;
  out.geometry.dims = level.extent("dimensions");
  out.geometry.world_from_index = level.matrix("affine");
  out.bricks = level.extent("bricks");
  if (out.bricks != brickLattice(out.geometry.dims, brick_size)) level.fail("bricks", "disagrees with the dimensions");
  out.stored_bricks = level.count("stored");
  out.stored_bytes = level.count("bytes");
  level.finish();
  return out;
}

void requireHalved(const VolumeGeometry& fine, const VolumeGeometry& coarse, const Reader& root,
                   const std::string& place) {
  const VolumeGeometry expected = coarserThan(fine);
  if (coarse.dims == expected.dims && coarse.world_from_index == expected.world_from_index) return;
  root.fail(place.c_str(), "is not the finer level at half the resolution");
}

// Position of the checksum's 32 digits; npos if there are none.
std::size_t digitsOf(const std::string& text) {
  const std::size_t key = text.rfind(kChecksumKey);
  if (key == std::string::npos) return key;
  const std::size_t digits = key + std::char_traits<char>::length(kChecksumKey);
  return digits + kDigits <= text.size() ? digits : std::string::npos;
}

void requireChecksum(const std::string& text, const std::filesystem::path& path) {
  const std::size_t digits = digitsOf(text);
  if (digits == std::string::npos)
    throw Error(ErrorCode::kDamaged, path, "",
                "has no checksum; the file is cut off or damaged, convert the source again");
  std::string zeroed = text;
  zeroed.replace(digits, kDigits, kDigits, '0');
  const std::string found = toHex(hashOf(zeroed));
  const std::string expected = text.substr(digits, kDigits);
  if (found != expected) {
    throw Error(ErrorCode::kDamaged, path, "",
                "checksum " + found + ", expected " + expected + "; the file is damaged, convert the source again");
  }
}

}  // namespace

void Manifest::placeIn(const VolumeGeometry& world) {
  const WorldChange change = worldChange(geometry(), world);
  assumption = assumptionText(geometry(), world);
  for (LevelInfo& level : levels) {
    level.geometry.world_from_index = change.of(level.geometry.world_from_index);
    level.geometry.frame = world.frame;
    level.geometry.unit = world.unit;
  }
  world_per_own *= change.lengths.of(1);
}

bool countsEachLabel(VolumeClass volume_class, VoxelType type, const ValueRange& range) {
  if (volume_class != VolumeClass::kLabels || range.empty()) return false;
  return sizeOf(type) <= 2 || (range.lo >= 0 && range.hi < static_cast<double>(kMostLabels - 1));
}

const char* wordOf(VolumeClass volume_class) { return nameIn(kClassNames, volume_class); }

const char* wordOf(PatientFrame frame) { return nameIn(kFrameNames, frame); }

std::array<double, 16> rowsOf(const glm::dmat4& affine) {
  std::array<double, 16> out;
  for (int i = 0; i < 16; ++i) out[static_cast<std::size_t>(i)] = affine[i % 4][i / 4];
  return out;
}

Extent3 Manifest::spanOf(int level) const {
  Extent3 out{1, 1, 1};
  for (int finer = 0; finer < level; ++finer) {
    const Extent3 by = halvingOf(levels[static_cast<std::size_t>(finer)].geometry);
    out = {out.x * by.x, out.y * by.y, out.z * by.z};
  }
  return out;
}

void Manifest::layBricks() {
  for (LevelInfo& level : levels) level.bricks = brickLattice(level.geometry.dims, brick_size);
}

std::vector<Extent3> Manifest::lattices() const {
  std::vector<Extent3> out;
  for (const LevelInfo& level : levels) out.push_back(level.bricks);
  return out;
}

nlohmann::ordered_json volumeJson(const Manifest& m) {
  const VolumeGeometry& geometry = m.geometry();
  return {{"dimensions", triple(geometry.dims)},
          {"type", std::string(nameOf(m.type))},
          {"range", m.range.empty() ? Json(nullptr) : Json::array({numberJson(m.range.lo), numberJson(m.range.hi)})},
          {"nanCount", m.nan_count},
          {"histogram", {{"lo", m.histogram.lo}, {"hi", m.histogram.hi}, {"counts", m.histogram.counts}}},
          {"background", numberJson(m.background)},
          {"class", wordOf(m.volume_class)},
          {"affine", rowsOf(geometry.world_from_index)},
          {"unit", geometry.unit},
          {"frame", wordOf(geometry.frame)}};
}

std::string manifestText(const Manifest& m) {
  Json levels = Json::array();
  for (const LevelInfo& level : m.levels) {
    levels.push_back({{"dimensions", triple(level.geometry.dims)},
                      {"affine", rowsOf(level.geometry.world_from_index)},
                      {"bricks", triple(level.bricks)},
                      {"stored", level.stored_bricks},
                      {"bytes", level.stored_bytes}});
  }
  Json json = {{"kiln", m.format}};
  json.update(volumeJson(m));
  json.update({
      {"brickSize", m.brick_size},
      {"apron", m.apron},
      {"cellSize", kCellSize},
      {"levels", levels},
      {"codec", {{"container", m.container_version}, {"compression", "blosc"}}},
      {"index", {{"file", kIndexFile}, {"bytes", m.index_bytes}, {"checksum", toHex(m.index_checksum)}}},
      {"source", sourceJson(m.source, m.format)},
  });
  if (m.format >= 5) json["look"] = lookJson(m.look);
  json["checksum"] = std::string(kDigits, '0');
  std::string text = jsonText(std::move(json), 1) + "\n";
  text.replace(digitsOf(text), kDigits, toHex(hashOf(text)));
  return text;
}

namespace {

// Tables have an entry for each value of a small integer type: a loop over a range beyond the type would never end.
void requireValuesOf(VoxelType type, const ValueRange& range, const Reader& root) {
  if (range.lo > range.hi) root.fail("range", "its first number is above its second");
  const bool holds = withVoxelType(type, [&]<class T>(std::type_identity<T>) {
    if constexpr (std::is_integral_v<T>)
      return range.lo >= static_cast<double>(std::numeric_limits<T>::min()) &&
             range.hi <= static_cast<double>(std::numeric_limits<T>::max());
    return true;
  });
  if (!holds) root.fail("range", fmt::format("has values outside the range of {}", nameOf(type)));
}

}  // namespace

Manifest parseManifest(const std::string& text, const std::filesystem::path& path) {
  requireChecksum(text, path);
  const Parsed json = Parsed::parse(text, nullptr, /*allow_exceptions=*/false);
  if (json.is_discarded())
    throw Error(ErrorCode::kFormat, path, "",
                "is not JSON; restore this file of the store, or convert the source again");
  Reader root(json, "", path);
  const std::int64_t version = root.integer("kiln", 0, 1'000'000);
  if (version < kFirstFormatVersion || version > kFormatVersion) {
    throw Error(ErrorCode::kUnsupported, path, "kiln",
                fmt::format("store format {}, but this version reads formats {} to {} only; convert the source again, "
                            "or take the version that made the store",
                            version, kFirstFormatVersion, kFormatVersion));
  }
  Manifest m;
  m.format = static_cast<int>(version);
  const std::optional<VoxelType> type = voxelTypeNamed(root.value<std::string>("type"));
  if (!type) root.fail("type", "is not a voxel type");
  m.type = *type;
  if (const Parsed& range = root.get("range"); !range.is_null()) {
    if (!range.is_array() || range.size() != 2) root.fail("range", "expected two numbers");
    const Parsed named = {{"lo", range[0]}, {"hi", range[1]}};
    Reader ends(named, "range.", path);
    m.range = {ends.number("lo"), ends.number("hi")};
    requireValuesOf(m.type, m.range, root);
  }
  m.nan_count = root.count("nanCount");
  Reader histogram(root.get("histogram"), "histogram.", path);
  m.histogram = {histogram.number("lo"), histogram.number("hi"), histogram.wholeNumbers<std::uint64_t>("counts")};
  histogram.finish();
  m.background = root.number("background");
  m.volume_class = root.named("class", kClassNames);
  if (m.volume_class == VolumeClass::kLabels && isFloating(m.type)) root.fail("class", "labels are whole numbers");
  m.brick_size = root.integer("brickSize", kCellSize, 1 << 20);
  if ((m.brick_size & (m.brick_size - 1)) != 0) root.fail("brickSize", "is not a power of two");
  m.apron = root.integer("apron", 1, 64);
  root.integer("cellSize", kCellSize, kCellSize);
  VolumeGeometry geometry;
  geometry.unit = root.value<std::string>("unit");
  geometry.frame = root.named("frame", kFrameNames);
  geometry.dims = root.extent("dimensions");
  geometry.world_from_index = root.matrix("affine");
  try {
    requireInvertible(geometry.world_from_index, "");
  } catch (const Error& error) {
    const std::string what = error.what();
    throw Error(ErrorCode::kFormat, path, "affine", what.substr(0, what.rfind(';')) + kStoreRemedy);
  }
  const Parsed& levels = root.get("levels");
  if (!levels.is_array() || levels.empty()) root.fail("levels", "expected at least one level");
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const std::string place = fmt::format("levels[{}]", i);
    m.levels.push_back(readLevel(Reader(levels[i], place + ".", path), geometry, m.brick_size));
    if (i > 0) requireHalved(m.levels[i - 1].geometry, m.levels[i].geometry, root, place);
  }
  if (m.geometry().dims != geometry.dims || m.geometry().world_from_index != geometry.world_from_index) {
    root.fail("levels", "the first level disagrees with the volume");
  }
  Reader codec(root.get("codec"), "codec.", path);
  m.container_version = codec.value<std::string>("container");
  codec.same("compression", "blosc");
  codec.finish();
  Reader index(root.get("index"), "index.", path);
  index.same("file", kIndexFile);
  m.index_bytes = index.count("bytes");
  m.index_checksum = index.checksum("checksum");
  index.finish();
  m.source = readSource(Reader(root.get("source"), "source.", path), m.format);
  if (m.format >= 5) m.look = readLook(Reader(root.get("look"), "look.", path), path);
  root.get("checksum");
  root.finish();
  return m;
}

}  // namespace kiln
