// Numbers and texts in JSON. Names of files and texts of headers need not be UTF-8; JSON must be.
// Internal, not installed.
#pragma once

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "base/text.h"

namespace kiln {

namespace json_detail {
template <class Json>
void makeUtf8(Json& value) {
  if (value.is_string()) {
    auto& text = value.template get_ref<std::string&>();
    text = utf8Of(text);
  } else if (value.is_structured()) {
    for (Json& inside : value) makeUtf8(inside);
  }
}
}  // namespace json_detail

/// Returns the number. JSON has no infinities and no NaN: they become the texts "inf", "-inf" and "nan".
inline nlohmann::ordered_json numberJson(double value) {
  if (std::isfinite(value)) return value;
  return std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
}

/// Returns the JSON text, in one line for a negative indent. Strings that are not UTF-8 are escaped by utf8Of.
template <class Json>
std::string jsonText(Json value, int indent) {
  json_detail::makeUtf8(value);
  return value.dump(indent);
}

}  // namespace kiln
