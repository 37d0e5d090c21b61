#include "job/camera_file.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <glm/gtc/quaternion.hpp>
#include <glm/mat4x4.hpp>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/file/file.h"
#include "base/text.h"
#include "ingest/source/json_node.h"
#include "ingest/source/xml_reader.h"

namespace kiln {
namespace {

namespace fs = std::filesystem;

// Upper bound for the memory of a parsed glTF file. unit: bytes.
constexpr std::uint64_t kJsonMemory = std::uint64_t{256} << 20;
constexpr std::size_t kMostNodes = 1 << 16;
// Upper bound for the JSON chunk of a .glb file; the meshes behind are not read. unit: bytes.
constexpr std::uint32_t kLongestJson = 16 << 20;

// The elements of a ParaView file: <Property name="CameraPosition"><Element index="0" value="1.5"/>…
class ParaViewCamera final : public XmlReader {
 public:
  explicit ParaViewCamera(const File& file) : XmlReader(file) {}

  glm::dvec3 vector(const std::string& name) const {
    const std::vector<double> values = numbers(name, 3);
    return {values[0], values[1], values[2]};
  }
  double number(const std::string& name) const { return numbers(name, 1).front(); }
  bool has(const std::string& name) const { return properties_.contains(name); }

 private:
  void begin(std::string_view name, const XmlAttributes& attributes) override {
    if (name == "Property") property_ = attributes.get("name");
    if (name != "Element" || property_.empty()) return;
    const std::string text = attributes.get("value");
    const std::optional<double> value = decimalOf<double>(text);
    if (!value) fail(fmt::format("{}: expected a number (found '{}'); save the camera again", property_, text));
    properties_[property_].push_back(*value);
  }

  std::vector<double> numbers(const std::string& name, std::size_t count) const {
    const auto found = properties_.find(name);
    const std::size_t there = found == properties_.end() ? 0 : found->second.size();
    if (there != count)
      throw Error(ErrorCode::kFormat, file().path(), name,
                  fmt::format("expected {} (found {}); save the camera again with ParaView's Adjust Camera",
                              count == 1 ? "a number" : fmt::format("{} numbers", count), there));
    return found->second;
  }

  std::string property_;
  std::map<std::string, std::vector<double>> properties_;
};

void readParaView(const fs::path& path, CameraSpec& camera) {
  const File file(path);
  ParaViewCamera from(file);
  from.parse();
  camera.eye = from.vector("CameraPosition");
  camera.target = from.vector("CameraFocalPoint");
  camera.up = from.vector("CameraViewUp");
  if (from.has("CameraParallelProjection") && from.number("CameraParallelProjection") != 0) {
    camera.projection = Projection::kOrthographic;
    camera.height = 2 * from.number("CameraParallelScale");  // the scale is half the height
  } else {
    camera.projection = Projection::kPerspective;
    camera.fov_deg = from.number("CameraViewAngle");
  }
}

// The JSON of a .glb file is its first chunk.
std::string jsonOfBinary(const File& file) {
  std::array<std::uint32_t, 5> head{};  // magic, version, length, length of the chunk, type of the chunk
  file.readAt(0, std::as_writable_bytes(std::span(head)));
  const bool json = std::memcmp(&head[0], "glTF", 4) == 0 && std::memcmp(&head[4], "JSON", 4) == 0;
  if (!json || head[1] != 2)
    throw Error(ErrorCode::kFormat, file.path(), "header", "expected a glTF 2 file that begins with JSON");
  if (head[3] > kLongestJson)
    throw Error(ErrorCode::kUnsupported, file.path(), "JSON",
                fmt::format("expected at most {} bytes (found {}); export the camera alone", kLongestJson, head[3]));
  std::string out(head[3], ' ');
  file.readAt(sizeof head, std::as_writable_bytes(std::span(out)));
  return out;
}

std::vector<double> numbersIn(const JsonNode& node, const std::string& key, std::size_t count,
                              std::vector<double> otherwise) {
  const std::optional<JsonNode> found = node.find(key);
  if (!found) return otherwise;
  const std::vector<double> out = found->numbers();
  if (out.size() != count) found->fail(fmt::format("expected {} numbers (found {})", count, out.size()));
  return out;
}

glm::dmat4 placeOf(const JsonNode& node) {
  glm::dmat4 out(1.0);
  if (node.find("matrix")) {
    const std::vector<double> m = numbersIn(node, "matrix", 16, {});  // column by column
    for (int i = 0; i < 16; ++i) out[i / 4][i % 4] = m[static_cast<std::size_t>(i)];
    return out;
  }
  const std::vector<double> t = numbersIn(node, "translation", 3, {0, 0, 0});
  const std::vector<double> r = numbersIn(node, "rotation", 4, {0, 0, 0, 1});  // x, y, z, w
  const std::vector<double> s = numbersIn(node, "scale", 3, {1, 1, 1});
  out = glm::mat4_cast(glm::dquat(r[3], r[0], r[1], r[2]));
  for (int axis = 0; axis < 3; ++axis) out[axis] *= s[static_cast<std::size_t>(axis)];
  out[3] = glm::dvec4(t[0], t[1], t[2], 1);
  return out;
}

std::size_t indexOf(const JsonNode& node, std::size_t count) {
  const std::int64_t index = node.whole();
  if (index < 0 || index >= static_cast<std::int64_t>(count))
    node.fail(fmt::format("expected a number from 0 to below {}", count));
  return static_cast<std::size_t>(index);
}

// The node's place in the world, through its parents.
glm::dmat4 worldPlaceOf(const std::vector<JsonNode>& nodes, std::size_t node) {
  std::vector<std::optional<std::size_t>> parents(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::optional<JsonNode> children = nodes[i].find("children");
    if (!children) continue;
    for (const JsonNode& child : children->items(kMostNodes)) parents[indexOf(child, nodes.size())] = i;
  }
  glm::dmat4 out = placeOf(nodes[node]);
  std::size_t steps = 0;
  for (std::optional<std::size_t> at = parents[node]; at; at = parents[*at]) {
    if (++steps > nodes.size()) nodes[*at].fail("expected a tree of nodes (found a node that contains itself)");
    out = placeOf(nodes[*at]) * out;
  }
  return out;
}

void setLens(const JsonNode& lens, CameraSpec& camera) {
  const std::string type = lens.at("type").text();
  if (type == "orthographic") {
    camera.projection = Projection::kOrthographic;
    camera.height = 2 * lens.at("orthographic").at("ymag").number();
  } else if (type == "perspective") {
    camera.projection = Projection::kPerspective;
    camera.fov_deg = lens.at("perspective").at("yfov").number() * 180 / std::numbers::pi;
  } else {
    lens.at("type").fail("expected perspective or orthographic");
  }
}

void readGltf(const JsonNode& document, CameraSpec& camera) {
  const std::vector<JsonNode> cameras =
      document.find("cameras") ? document.at("cameras").items(kMostNodes) : std::vector<JsonNode>();
  const std::vector<JsonNode> nodes =
      document.find("nodes") ? document.at("nodes").items(kMostNodes) : std::vector<JsonNode>();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::optional<JsonNode> index = nodes[i].find("camera");
    if (!index) continue;
    setLens(cameras.at(indexOf(*index, cameras.size())), camera);
    const glm::dmat4 world = worldPlaceOf(nodes, i);
    const glm::dvec3 eye(world[3]), up(world[1]), back(world[2]);
    if (!(glm::length(up) > 0 && glm::length(back) > 0)) nodes[i].fail("expected axes of a length above 0");
    const glm::dvec3 forward = -glm::normalize(back);
    const double depth = glm::dot(-eye, forward);
    camera.eye = eye;
    camera.up = glm::normalize(up);
    camera.target = eye + (depth > 0 ? depth : 1) * forward;
    return;
  }
  document.fail("expected a node with a camera; export the file again with cameras");
}

}  // namespace

void readCameraFile(const fs::path& path, CameraSpec& camera) {
  const std::string ending = extensionOf(path);
  if (ending == ".pvcc") return readParaView(path, camera);
  if (ending == ".gltf") return readGltf(JsonNode(path, kJsonMemory), camera);
  if (ending == ".glb") return readGltf(JsonNode(path, jsonOfBinary(File(path)), kJsonMemory), camera);
  throw Error(ErrorCode::kUnsupported, path, "",
              "expected a camera file .pvcc (ParaView), .gltf or .glb; export the camera in one of these formats");
}

}  // namespace kiln
