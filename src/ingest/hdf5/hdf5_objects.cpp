#include "ingest/hdf5/hdf5_objects.h"

#include <algorithm>

namespace kiln {
namespace {

// Lists of single letters are one text, as Imaris writes it.
std::string joined(const JsonNode& node) {
  if (node.isText()) return node.text();
  std::string out;
  for (const JsonNode& item : node.items()) {
    if (!item.isText()) return "";
    out += item.text();
  }
  return out;
}

}  // namespace

std::optional<std::string> Hdf5Object::text(const std::string& attribute) const {
  const std::optional<JsonNode> found = attributes.find(attribute);
  if (!found || (!found->isText() && !found->isList())) return std::nullopt;
  return joined(*found);
}

std::optional<double> Hdf5Object::number(const std::string& attribute) const {
  const std::optional<JsonNode> found = attributes.find(attribute);
  if (!found) return std::nullopt;
  if (found->isNumber()) return found->number();
  if (!found->isText() && !found->isList()) return std::nullopt;
  const std::vector<double> list = numbers(attribute);
  if (list.size() == 1) return list.front();
  try {
    return std::stod(joined(*found));
  } catch (const std::logic_error&) {
    return std::nullopt;
  }
}

std::vector<double> Hdf5Object::numbers(const std::string& attribute) const {
  const std::optional<JsonNode> found = attributes.find(attribute);
  std::vector<double> out;
  if (!found || !found->isList()) return out;
  for (const JsonNode& item : found->items()) {
    if (!item.isNumber()) return {};
    out.push_back(item.number());
  }
  return out;
}

std::vector<std::string> Hdf5Object::texts(const std::string& attribute) const {
  const std::optional<JsonNode> found = attributes.find(attribute);
  std::vector<std::string> out;
  if (!found || !found->isList()) return out;
  for (const JsonNode& item : found->items()) out.push_back(item.isText() ? item.text() : "");
  return out;
}

Hdf5Objects::Hdf5Objects(const std::filesystem::path& file, const std::string& json) {
  const JsonNode root(file, json);
  for (const std::string& path : root.keys()) {
    const JsonNode node = root.at(path);
    const std::string kind = node.at("kind").text();
    if (kind == "damaged") continue;
    Hdf5Object object{kind == "dataset", {}, "", {}, node.at("attributes")};
    if (object.is_dataset) {
      object.shape = node.at("shape").wholes();
      if (const std::optional<JsonNode> type = node.find("type")) object.type = type->at("name").text();
      if (const std::optional<JsonNode> values = node.find("values"))
        for (const JsonNode& value : values->items())
          if (value.isNumber()) object.values.push_back(value.number());
    }
    all_.emplace(path, std::move(object));
  }
}

const Hdf5Object* Hdf5Objects::find(const std::string& path) const {
  const auto found = all_.find(path);
  return found == all_.end() ? nullptr : &found->second;
}

bool Hdf5Objects::hasDataset(const std::string& path) const {
  const Hdf5Object* const found = find(path);
  return found != nullptr && found->is_dataset && !found->type.empty();
}

std::vector<std::string> Hdf5Objects::volumes() const {
  std::vector<std::string> out;
  for (const auto& [path, object] : all_) {
    const auto thick = std::count_if(object.shape.begin(), object.shape.end(), [](std::int64_t n) { return n > 1; });
    if (object.is_dataset && !object.type.empty() && object.shape.size() >= 3 && thick >= 3) out.push_back(path);
  }
  return out;
}

}  // namespace kiln
