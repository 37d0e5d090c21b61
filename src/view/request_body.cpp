#include "view/request_body.h"

#include <fmt/format.h>

#include <cmath>

#include "base/error.h"
#include "view/view_painter.h"

namespace kiln {
namespace {

using nlohmann::json;

}  // namespace

RequestBody RequestBody::parse(const std::string& text) {
  // Copies and texts of a value take stack for each of its depths; each object of a job takes some 50 microseconds.
  static constexpr int kDeepest = 32, kMostObjects = 20'000;
  int objects = 0;
  const auto bounded = [&objects](int depth, json::parse_event_t event, json&) {
    if (depth > kDeepest) throw Error(ErrorCode::kFormat, "the request is nested too deeply; send fewer levels");
    if (event == json::parse_event_t::object_start && ++objects > kMostObjects)
      throw Error(
          ErrorCode::kFormat,
          fmt::format("the request: expected at most {} objects; send fewer keys, lights or points", kMostObjects));
    return true;
  };
  json value = json::parse(text.empty() ? "{}" : text, bounded, false);
  if (value.is_discarded()) throw Error(ErrorCode::kFormat, "the request is no JSON; send an object");
  if (!value.is_object()) throw Error(ErrorCode::kFormat, "the request is no object; send an object");
  return RequestBody(std::move(value));
}

const json* RequestBody::find(const char* key) const {
  const auto found = value_.find(key);
  return found == value_.end() || found->is_null() ? nullptr : &*found;
}

std::optional<std::int64_t> RequestBody::whole(const json& value, std::int64_t least, std::int64_t most) {
  if (!value.is_number()) return std::nullopt;
  const double given = value.get<double>();
  if (!(given >= static_cast<double>(least) && given <= static_cast<double>(most)) || given != std::floor(given))
    return std::nullopt;
  return static_cast<std::int64_t>(given);
}

void RequestBody::refuse(const char* key, const std::string& expected) {
  throw Error(ErrorCode::kUsage, fmt::format("{}: expected {}", key, expected));
}

std::int64_t RequestBody::integer(const char* key, std::int64_t least, std::int64_t most,
                                  std::optional<std::int64_t> otherwise) const {
  const json* const found = find(key);
  if (found == nullptr && otherwise) return *otherwise;
  const auto out = found ? whole(*found, least, most) : std::nullopt;
  if (!out) refuse(key, fmt::format("a whole number from {} to {}", least, most));
  return *out;
}

bool RequestBody::flag(const char* key) const {
  const json* const found = find(key);
  if (found == nullptr) return false;
  if (!found->is_boolean()) refuse(key, "true or false");
  return found->get<bool>();
}

std::string RequestBody::text(const char* key) const {
  const json* const found = find(key);
  if (found == nullptr || !found->is_string()) refuse(key, "a text");
  return found->get<std::string>();
}

std::optional<ImageSize> RequestBody::sizeIfThere(const char* key) const {
  const json* const found = find(key);
  if (found == nullptr) return std::nullopt;
  if (found->is_array() && found->size() == 2) {
    const auto width = whole((*found)[0], 1, kLargestViewSide), height = whole((*found)[1], 1, kLargestViewSide);
    if (width && height) return ImageSize{static_cast<int>(*width), static_cast<int>(*height)};
  }
  refuse(key, fmt::format("[width, height], each from 1 to {}", kLargestViewSide));
}

ImageSize RequestBody::size() const {
  const auto out = sizeIfThere();
  if (!out) refuse("size", "[width, height]");
  return *out;
}

const json& RequestBody::job() const {
  const json* const found = find("job");
  if (found == nullptr) refuse("job", "a job");
  return *found;
}

}  // namespace kiln
