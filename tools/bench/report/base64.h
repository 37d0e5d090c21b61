// Encodes bytes as text, for pictures inside an HTML page. Source: RFC 4648 §4.
#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace kiln {

/// shape: 4 characters for each started group of 3 bytes, padded with '='.
std::string base64Of(std::span<const std::byte> data);

}  // namespace kiln
