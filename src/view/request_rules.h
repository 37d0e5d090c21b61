// Tests of a request's header, against DNS rebinding, other pages and guessed tokens.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace kiln {

/// Returns 128 random bits as 32 hexadecimal digits. throws: Error kIo.
std::string randomToken();

/// Returns whether a header Host names this machine or a host of `allowed`, with any port: a tunnel has another port
/// than the server, and the name alone reveals DNS rebinding.
bool isOwnHost(std::string_view host, const std::vector<std::string>& allowed);

/// Returns whether a header Origin is the page of `host`, or of a host of `allowed`: a proxy may put its own name for
/// the server into Host.
bool isOwnOrigin(std::string_view origin, std::string_view host, const std::vector<std::string>& allowed);

/// Returns whether a header Authorization bears the token, in a time that does not depend on the place of a difference.
bool bearsToken(std::string_view authorization, std::string_view token);

}  // namespace kiln
