// A JSON object that is read key by key with the error a user needs: which file, which key, what was found, what was
// expected. nlohmann's parser lives behind this header.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "job/job_keys.h"

namespace kiln {

/// The part of a message of the JSON library that is written for people: without its code, line and column.
std::string readableJsonError(std::string message);

/// The word of `known` with the least edit distance to `word`. requires: known is not empty.
std::string_view nearestWord(std::string_view word, std::span<const std::string_view> known);

/// The longest a list may be, and the word for its entries: 64 "lights".
struct ListLimit {
  std::size_t most;
  std::string_view entries;
};

/// An object inside a parsed document; it keeps the document alive.
/// throws: every member, Error kUsage "FILE: line N, KEY: expected …, found …" where the value is not what it asks for.
class JobObject {
 public:
  /// The document's root. Comments are allowed. throws: Error kFormat with line and column where the text is not JSON
  /// or an object has a key twice; kUsage where the root is not an object.
  static JobObject parse(const std::string& text, const std::filesystem::path& path);
  /// Reads a document that is one object or a list of objects, as above.
  static std::vector<JobObject> parseSeveral(const std::string& text, const std::filesystem::path& path);

  /// throws: Error kUsage for a key that is in neither `known` nor `more`, naming the nearest key.
  void requireKnown(JobKeys known, JobKeys more = {}) const;
  void requireKnown(std::initializer_list<std::string_view> known) const;
  bool has(std::string_view key) const { return find(key) != nullptr; }
  bool isText(std::string_view key) const;
  bool isNumber(std::string_view key) const;
  bool isObject(std::string_view key) const;

  /// Empty where the key is not there. `expected` describes the legal values: "a number of degrees in (0, 180)".
  std::optional<double> number(std::string_view key, std::string_view expected, bool (*legal)(double)) const;
  std::optional<std::int64_t> integer(std::string_view key, std::int64_t least, std::int64_t most) const;
  std::optional<std::string> text(std::string_view key, std::string_view expected) const;
  /// The place of the value in `names`.
  std::optional<std::size_t> choice(std::string_view key, std::span<const std::string_view> names) const;
  std::optional<bool> flag(std::string_view key) const;
  /// A list of words, none of them twice: their places in `names`.
  std::optional<std::vector<std::size_t>> choices(std::string_view key, std::span<const std::string_view> names) const;
  std::optional<std::vector<std::string>> texts(std::string_view key, std::string_view expected) const;
  std::optional<std::vector<double>> numberList(std::string_view key, std::string_view expected,
                                                bool (*legal)(double)) const;
  std::optional<std::vector<std::array<double, 2>>> pairs(std::string_view key, std::string_view expected,
                                                          bool (*legal)(double)) const;
  /// A list of 4 rows of 4 numbers. shape: row by row.
  std::optional<std::vector<std::array<double, 16>>> matrices(std::string_view key, std::string_view expected,
                                                              ListLimit limit, bool (*legal)(double)) const;
  std::optional<JobObject> object(std::string_view key) const;
  std::optional<std::vector<JobObject>> objects(std::string_view key, std::string_view expected, ListLimit limit) const;
  template <std::size_t N>
  std::optional<std::array<double, N>> numbers(std::string_view key, std::string_view expected,
                                               bool (*legal)(double)) const {
    std::array<double, N> out;
    return fill(key, expected, legal, out) ? std::optional(out) : std::nullopt;
  }

  /// throws: Error kUsage at `key`: "expected …, found …", or `sentence` as it stands.
  [[noreturn]] void refuse(std::string_view key, std::string_view expected) const;
  [[noreturn]] void complain(std::string_view key, const std::string& sentence) const;
  const std::filesystem::path& path() const { return path_; }
  /// "camera.fov": where `key` of this object is in the document.
  std::string placeOf(std::string_view key) const;

 private:
  using Json = std::shared_ptr<const nlohmann::json>;
  using Text = std::shared_ptr<const std::string>;
  JobObject(Json value, Text text, std::filesystem::path path, std::string place);
  [[noreturn]] void complainAt(const std::string& place, const std::string& sentence) const;
  void requireWithin(std::string_view key, ListLimit limit, const nlohmann::json& list) const;
  void requireOneOf(std::span<const std::string_view> known) const;
  const nlohmann::json* find(std::string_view key) const;
  bool fill(std::string_view key, std::string_view expected, bool (*legal)(double), std::span<double> out) const;
  JobObject inside(const nlohmann::json& value, std::string place) const;

  Json value_;
  Text text_;  // the whole document
  std::filesystem::path path_;
  std::string place_;  // path of this object; empty for the root
};

/// The ranges that keys have.
namespace legal {
/// Anything whose square and cube a double holds.
bool length(double v);
bool positiveLength(double v);
bool fraction(double v);  // [0, 1]
bool voxelValue(double v);
bool shadingWeight(double v);
bool shadingPower(double v);
}  // namespace legal

}  // namespace kiln
