// Known: the hosts, origins and tokens that belong to a server on this machine.
#include "view/request_rules.h"

#include <gtest/gtest.h>

#include <set>

namespace kiln::test {
namespace {

const std::vector<std::string> kAllowed = {"Proxy.example"};

TEST(RequestRules, HostsOfThisMachineAndOfProxies_areOwn) {
  for (const char* own : {"localhost", "LOCALHOST:8000", "127.0.0.1", "127.0.0.1:1", "[::1]", "[::1]:65535",
                          "proxy.example", "PROXY.example:443"})
    EXPECT_TRUE(isOwnHost(own, kAllowed)) << own;
  for (const char* other : {"", ":", ":80", "localhost.evil.example", "localhost@evil.example", "localhost:80:80",
                            "localhost:x", "localhost:123456", "127.0.0.2", "127.0.0.1.evil.example", "[::1", "[::1]x",
                            "[::2]", "[", "evil.example", "proxy.example.evil", "evil-proxy.example", " localhost"})
    EXPECT_FALSE(isOwnHost(other, kAllowed)) << other;
  EXPECT_FALSE(isOwnHost("proxy.example", {}));
}

TEST(RequestRules, TheOriginIsThePageOfTheHost) {
  EXPECT_TRUE(isOwnOrigin("http://localhost:8000", "localhost:8000", {}));
  EXPECT_TRUE(isOwnOrigin("https://LOCALHOST:8000", "localhost:8000", {}));
  EXPECT_TRUE(isOwnOrigin("https://proxy.example", "127.0.0.1:8000", kAllowed));
  for (const char* other : {"", "null", "http://", "http://localhost", "http://localhost:8001", "ftp://localhost:8000",
                            "HTTP//localhost:8000", "http://evil.example", "http://localhost:8000.evil.example",
                            "http://evil.example/localhost:8000", "file://"})
    EXPECT_FALSE(isOwnOrigin(other, "localhost:8000", kAllowed)) << other;
}

TEST(RequestRules, OnlyTheWholeTokenIsBorne) {
  const std::string token = randomToken();
  EXPECT_EQ(token.size(), 32u);
  EXPECT_EQ(token.find_first_not_of("0123456789abcdef"), std::string::npos);
  EXPECT_TRUE(bearsToken("Bearer " + token, token));
  EXPECT_TRUE(bearsToken("bearer " + token, token));
  std::string changed = token;
  changed.back() = changed.back() == '0' ? '1' : '0';
  for (const std::string& wrong :
       {std::string(), std::string("Bearer"), std::string("Bearer "), token, "Basic " + token, "Bearer  " + token,
        "Bearer " + token + "0", "Bearer " + token.substr(1), "Bearer " + changed})
    EXPECT_FALSE(bearsToken(wrong, token)) << wrong;
}

TEST(RequestRules, TokensDiffer) {
  std::set<std::string> tokens;
  for (int i = 0; i < 100; ++i) tokens.insert(randomToken());
  EXPECT_EQ(tokens.size(), 100u);
}

}  // namespace
}  // namespace kiln::test
