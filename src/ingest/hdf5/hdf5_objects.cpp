#include "ingest/hdf5/hdf5_objects.h"

#include <algorithm>
#include <utility>

#include "ingest/source/header_text.h"

namespace kiln {
namespace {

// Imaris writes a text as a list of letters, which the reader gives as {"letters": TEXT}.
std::optional<std::string> lettersOf(const JsonNode& value) {
  const std::optional<JsonNode> letters = value.findIn("letters");
  return letters ? std::optional(letters->text()) : std::nullopt;
}

std::optional<std::string> textOf(const JsonNode& value) {
  if (value.isText()) return value.text();
  if (!value.isList()) return lettersOf(value);
  const std::vector<JsonNode> items = value.items();
  return items.size() == 1 && items.front().isText() ? std::optional(items.front().text()) : std::nullopt;
}

}  // namespace

std::string parentOf(const std::string& path) {
  const std::size_t slash = path.find_last_of('/');
  return slash == 0 ? "" : path.substr(0, slash);
}

std::optional<std::string> Hdf5Object::text(const std::string& attribute) const {
  const std::optional<JsonNode> found = attributes.find(attribute);
  return found ? textOf(*found) : std::nullopt;
}

std::optional<double> Hdf5Object::number(const std::string& attribute) const {
  const std::optional<JsonNode> found = attributes.find(attribute);
  if (!found) return std::nullopt;
  if (found->isNumber()) return found->number();
  if (const std::vector<double> list = numbers(attribute); list.size() == 1) return list.front();
  const std::optional<std::string> text = textOf(*found);
  return text ? doubleOf(trimmed(*text)) : std::nullopt;
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
  if (!found) return out;
  if (const std::optional<std::string> letters = lettersOf(*found))
    for (const char letter : *letters) out.emplace_back(1, letter);
  if (!found->isList()) return out;
  for (const JsonNode& item : found->items()) out.push_back(item.isText() ? item.text() : "");
  return out;
}

Hdf5Objects::Hdf5Objects(const std::filesystem::path& file, std::string json, std::uint64_t memory_bytes) {
  const JsonNode answer(file, std::move(json), memory_bytes);
  are_others_cut_ = answer.at("are_others_cut").truth();
  for (const JsonNode& pair : answer.at("objects").items()) {
    const std::vector<JsonNode> path_and_object = pair.items(2);
    if (path_and_object.size() != 2) pair.fail("must be a path and an object");
    const JsonNode& node = path_and_object.back();
    Hdf5Object object{
        node.at("kind").text() == "dataset", node.find("link").has_value(), {}, "", {}, {}, node.at("attributes")};
    if (object.is_dataset) {
      object.shape = node.at("shape").wholes();
      if (const std::optional<JsonNode> type = node.find("type")) object.type = type->at("name").text();
      if (const std::optional<JsonNode> values = node.find("values")) object.values = values->numbers();
      if (const std::optional<JsonNode> scales = node.find("scales")) object.scales = scales->texts();
    }
    all_.emplace(path_and_object.front().text(), std::move(object));
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
    if (object.is_dataset && !object.is_link && !object.type.empty() && object.shape.size() >= 3 && thick >= 3)
      out.push_back(path);
  }
  return out;
}

}  // namespace kiln
