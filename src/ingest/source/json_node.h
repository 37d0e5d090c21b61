// Headers in JSON. Every error names the file and the key.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace kiln {

/// Throws Error kBudget if a header of `file` that takes `needed_bytes` in memory exceeds the memory.
void requireHeaderFits(const std::filesystem::path& file, std::uint64_t needed_bytes, std::uint64_t memory_bytes);

/// A value of a JSON file.
class JsonNode {
 public:
  /// Reads a whole file, without consolidated metadata. NaN and Infinity may stand without quotes. throws: Error
  /// kNotFound, kIo; kBudget if the values may take more than `memory_bytes`; kFormat if the file is no JSON, is larger
  /// than 16 MiB, or has too many or too deep values.
  JsonNode(const std::filesystem::path& file, std::uint64_t memory_bytes);
  /// Parses `text`, which describes `file`. throws: Error kFormat; kBudget if text and values may take more than
  /// `memory_bytes`.
  JsonNode(const std::filesystem::path& file, std::string text, std::uint64_t memory_bytes);

  const std::filesystem::path& file() const { return file_; }
  bool isText() const { return value_->is_string(); }
  bool isNumber() const { return value_->is_number(); }
  bool isList() const { return value_->is_array(); }
  bool isObject() const { return value_->is_object(); }
  bool isTruth() const { return value_->is_boolean(); }

  /// Returns the member `key`; nothing if the key is missing or its value is null. throws: Error kFormat if this value
  /// is no object.
  std::optional<JsonNode> find(const std::string& key) const;
  /// As `find`, and nothing if this value is no object.
  std::optional<JsonNode> findIn(const std::string& key) const;
  /// throws: Error kFormat also if the member is missing.
  JsonNode at(const std::string& key) const;
  /// The keys of an object. throws: Error kFormat if this value is no object.
  std::vector<std::string> keys() const;
  /// The items of a list. throws: Error kFormat if this value is no list, or has more than `most` items.
  std::vector<JsonNode> items(std::size_t most = 1 << 16) const;

  /// Each throws Error kFormat if the value is of another kind. Numbers may be texts, as some programs write them; a
  /// list of one number is that number, as NetCDF writes fill values.
  std::string text() const;
  bool truth() const;
  std::int64_t whole() const;
  double number() const;
  std::vector<std::int64_t> wholes() const;
  std::vector<double> numbers() const;
  std::vector<std::string> texts() const;
  /// The value as a short text for a message.
  std::string shown() const;

  /// Throws Error kFormat, or kUnsupported, at this value.
  [[noreturn]] void fail(const std::string& what) const;
  [[noreturn]] void unsupported(const std::string& what) const;

 private:
  JsonNode(const JsonNode& parent, const nlohmann::json& value, std::string place);

  std::shared_ptr<const nlohmann::json> document_;
  const nlohmann::json* value_;
  std::filesystem::path file_;
  std::string place_;
};

}  // namespace kiln
