#include "view/request_rules.h"

#include <sys/random.h>
#include <sys/types.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstddef>

#include "base/error.h"
#include "base/text.h"

namespace kiln {
namespace {

bool equalInConstantTime(std::string_view a, std::string_view b) {
  unsigned different = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < b.size(); ++i)
    different |=
        static_cast<unsigned>(static_cast<unsigned char>(b[i]) ^ static_cast<unsigned char>(i < a.size() ? a[i] : 0));
  return different == 0;
}

// Returns the name of "name:port", "[::1]:port" or a name alone.
std::string_view nameOfHost(std::string_view host) {
  if (host.starts_with('[')) return host.substr(0, std::min(host.find(']'), host.size() - 1) + 1);
  return host.substr(0, host.find(':'));
}

bool isPort(std::string_view text) {
  return text.starts_with(':') && text.size() <= 6 && text.find_first_not_of("0123456789", 1) == std::string_view::npos;
}

bool isAmong(std::string_view name, const std::vector<std::string>& allowed) {
  return std::any_of(allowed.begin(), allowed.end(), [&](const std::string& one) { return name == lowered(one); });
}

}  // namespace

std::string randomToken() {
  std::array<unsigned char, 16> bytes;
  for (std::size_t have = 0; have < bytes.size();) {
    const ssize_t count = ::getrandom(bytes.data() + have, bytes.size() - have, 0);
    if (count < 0 && errno != EINTR) throw systemError(errno, {}, "drawing a random token");
    have += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
  }
  constexpr std::string_view kLetters = "0123456789abcdef";
  std::string out;
  for (const unsigned char byte : bytes) out += {kLetters[byte >> 4], kLetters[byte & 15]};
  return out;
}

bool isOwnHost(std::string_view host, const std::vector<std::string>& allowed) {
  const std::string name = lowered(nameOfHost(host));
  const std::string_view port = host.substr(name.size());
  if (!port.empty() && !isPort(port)) return false;
  return name == "127.0.0.1" || name == "localhost" || name == "[::1]" || isAmong(name, allowed);
}

bool isOwnOrigin(std::string_view origin, std::string_view host, const std::vector<std::string>& allowed) {
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!origin.starts_with(scheme)) continue;
    origin.remove_prefix(scheme.size());
    return lowered(origin) == lowered(host) || isAmong(lowered(nameOfHost(origin)), allowed);
  }
  return false;
}

bool bearsToken(std::string_view authorization, std::string_view token) {
  constexpr std::string_view kScheme = "bearer ";
  return authorization.size() >= kScheme.size() && lowered(authorization.substr(0, kScheme.size())) == kScheme &&
         equalInConstantTime(authorization.substr(kScheme.size()), token);
}

}  // namespace kiln
