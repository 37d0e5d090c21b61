// Colours written as text.
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace kiln {

/// The 148 names of colours in CSS, sorted: "aliceblue", …
std::span<const std::string_view> colorNames();

/// Describes the legal texts, for errors.
inline constexpr std::string_view kColorForms = "a name such as orange, #rgb or #rrggbb";

/// Returns the linear light of a name in any case, of #rgb or of #rrggbb, whose numbers are sRGB; nothing for other
/// texts. In 0..1.
std::optional<glm::dvec3> colorNamed(std::string_view text);

/// Returns "#rrggbb" of a colour in linear light.
std::string hexText(const glm::dvec3& color);

}  // namespace kiln
