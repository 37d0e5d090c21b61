// The JSON of a request. Every member throws Error kUsage naming the key.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "scene/camera/camera.h"

namespace kiln {

class RequestBody {
 public:
  /// throws: Error kFormat for no JSON, for a value that is no object, and for too many or too deep values.
  static RequestBody parse(const std::string& text);

  /// Returns null for a missing key, and for null.
  const nlohmann::json* find(const char* key) const;
  std::int64_t integer(const char* key, std::int64_t least, std::int64_t most,
                       std::optional<std::int64_t> otherwise = {}) const;
  /// False for a missing key.
  bool flag(const char* key) const;
  std::string text(const char* key) const;
  /// Reads [width, height]. unit: pixels.
  std::optional<ImageSize> sizeIfThere(const char* key = "size") const;
  ImageSize size() const;
  const nlohmann::json& job() const;

  /// Returns a value that is a whole number from `least` to `most`; nothing for any other value. throws: nothing.
  static std::optional<std::int64_t> whole(const nlohmann::json& value, std::int64_t least, std::int64_t most);
  [[noreturn]] static void refuse(const char* key, const std::string& expected);

 private:
  explicit RequestBody(nlohmann::json value) : value_(std::move(value)) {}
  nlohmann::json value_;
};

}  // namespace kiln
