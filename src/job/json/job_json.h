// A JSON object that is read key by key. Errors name file, key, found and expected value. Hides nlohmann's parser.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kiln {

/// Returns the readable part of a message of the JSON library: without code, line and column.
std::string readableJsonError(std::string message);

/// The greatest length of a list, and the word for its entries: 64 "lights".
struct ListLimit {
  std::size_t most;
  std::string_view entries;
};

/// The longest length: its square and its cube are finite. unit: world.
inline constexpr double kLongest = 1e30;

/// The legal values of a number.
struct NumberRange {
  double least, most;
  bool above = false, below = false;  // excludes `least` or `most` itself
  bool operator()(double value) const;
  /// "0.25 to 1"; empty if the limits are never met in practice.
  std::string text() const;
};
/// "a number of voxels from 0.25 to 1".
std::string expectedNumber(const NumberRange& range, std::string_view unit);
std::string expectedWhole(std::int64_t least, std::int64_t most, std::string_view unit);

/// A range that several options share, with its name in the schema.
struct SharedRange {
  std::string_view name;
  NumberRange range;
};

/// A flag of the command line, for errors: `found` quotes its text.
struct FlagText {
  std::string flag, found, expected;
};

/// An object inside a parsed document, kept alive by the object. throws: every member throws Error kUsage "FILE: line
/// N, KEY: expected …, found …" for a value of another kind or out of range.
class JobObject {
 public:
  using Legal = std::function<bool(double)>;

  /// The document's root. Comments are allowed. throws: Error kFormat with line and column for a text that is not JSON
  /// or has a key twice; kUsage for a root that is not an object.
  static JobObject parse(const std::string& text, const std::filesystem::path& path);
  /// Reads a document: one object, or a list of objects.
  static std::vector<JobObject> parseSeveral(const std::string& text, const std::filesystem::path& path);

  /// An object for the value of a flag. Errors name the flag instead of a file: "FLAG: expected …, found …".
  static JobObject ofFlag(const nlohmann::json& value, const FlagText& flag);

  /// throws: Error kUsage for a key outside `known`, naming the nearest key.
  void requireKnown(std::initializer_list<std::string_view> known) const;
  void requireOneOf(std::span<const std::string_view> known) const;
  bool has(std::string_view key) const { return find(key) != nullptr; }
  bool isText(std::string_view key) const;
  bool isNumber(std::string_view key) const;
  bool isObject(std::string_view key) const;
  /// The number `kiln` of this object, or else of the document: the version of its format. Nothing where neither has
  /// it.
  std::optional<double> format() const;

  /// Empty if the key is absent. `expected` describes the legal values: "a number of degrees in (0, 180)".
  std::optional<double> number(std::string_view key, std::string_view expected, bool (*legal)(double)) const;
  std::optional<double> number(std::string_view key, const NumberRange& range, std::string_view unit) const;
  std::optional<std::int64_t> integer(std::string_view key, std::int64_t least, std::int64_t most,
                                      std::string_view unit = {}) const;
  std::optional<std::string> text(std::string_view key, std::string_view expected) const;
  /// The place of the value in `names`.
  std::optional<std::size_t> choice(std::string_view key, std::span<const std::string_view> names) const;
  std::optional<bool> flag(std::string_view key) const;
  /// Reads a list of different words. Returns their places in `names`.
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
                                               const Legal& legal) const {
    std::array<double, N> out;
    return fill(key, expected, legal, out) ? std::optional(out) : std::nullopt;
  }

  /// throws: Error kUsage at `key`: "expected …, found …" and `hint`; or `sentence`, unchanged.
  [[noreturn]] void refuse(std::string_view key, std::string_view expected, std::string_view hint = "") const;
  [[noreturn]] void complain(std::string_view key, const std::string& sentence) const;
  const std::filesystem::path& path() const;
  /// Returns the path of `key` in the document: "camera.fov".
  std::string placeOf(std::string_view key) const;

 private:
  struct Document;  // what all objects of a document have in common: large lists of objects share one
  using Shared = std::shared_ptr<const Document>;
  JobObject(Shared document, const nlohmann::json& root, const nlohmann::json& value, std::string place);
  [[noreturn]] void complainAt(const std::string& place, const std::string& sentence) const;
  void requireWithin(std::string_view key, ListLimit limit, const nlohmann::json& list) const;
  const nlohmann::json* find(std::string_view key) const;
  bool fill(std::string_view key, std::string_view expected, const Legal& legal, std::span<double> out) const;
  JobObject inside(const nlohmann::json& value, std::string place) const;

  Shared document_;
  const nlohmann::json* root_;   // the document, or its entry where the document is a list
  const nlohmann::json* value_;  // this object
  std::string place_;            // path of this object; empty for the root
};

/// The ranges of numeric keys.
namespace legal {
bool length(double v);
bool fraction(double v);  // [0, 1]
bool voxelValue(double v);
}  // namespace legal

}  // namespace kiln
