// Known: the final picture is the file that `kiln render` makes of the saved job; signals end the viewer with exit code
// 0; wrong options are refused in one line.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/file/file.h"
#include "support/system/http_client.h"
#include "support/system/run_script.h"
#include "support/system/text_of.h"
#include "support/system/tool_test.h"

namespace kiln::test {
namespace {

using nlohmann::json;

class ViewCli : public ToolTest {
 protected:
  ViewCli() : ToolTest("view_") {}
  void SetUp() override { done({"convert", "phantom:head:48x48x48", in("h.kiln"), "--brick-size", "16"}); }
};

// A running viewer, for tests that call it while it runs.
struct Viewer {
  std::uint16_t port = 0;
  std::string token;

  // Reads "http://127.0.0.1:PORT/#TOKEN".
  static std::optional<Viewer> of(const std::string& out) {
    const std::string before = "http://127.0.0.1:";
    const std::size_t at = out.find(before), mark = out.find("/#"), end = out.find('\n');
    if (at == std::string::npos || mark == std::string::npos || end == std::string::npos) return std::nullopt;
    return Viewer{static_cast<std::uint16_t>(std::stoi(out.substr(at + before.size()))),
                  out.substr(mark + 2, end - mark - 2)};
  }
  std::string answerTo(const std::string& name, const json& body) const {
    HttpClient client(port);
    const std::string text = body.dump();
    client.send("POST /api/" + name + " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nAuthorization: Bearer " +
                token + "\r\nContent-Type: application/json\r\nContent-Length: " + std::to_string(text.size()) +
                "\r\n\r\n" + text);
    return client.receive(60);
  }
};

// Returns the payload of the record with the stage in a chunked answer.
std::string payloadOf(const std::string& answer, const std::string& stage) {
  std::string body;
  for (std::size_t at = answer.find("\r\n\r\n") + 4; at < answer.size();) {
    const std::size_t line = answer.find("\r\n", at), size = std::stoul(answer.substr(at, line - at), nullptr, 16);
    body += answer.substr(line + 2, size);
    at = line + 2 + size + 2;
  }
  const auto four = [&](std::size_t at) {
    std::size_t out = 0;
    for (std::size_t i = 4; i-- > 0;) out = out << 8 | static_cast<unsigned char>(body.at(at + i));
    return out;
  };
  for (std::size_t at = 0; at < body.size();) {
    const std::size_t json_bytes = four(at), payload_bytes = four(at + 4 + json_bytes);
    const json record = json::parse(body.substr(at + 4, json_bytes));
    if (record.value("stage", "") == stage) return body.substr(at + 8 + json_bytes, payload_bytes);
    at += 8 + json_bytes + payload_bytes;
  }
  return {};
}

TEST_F(ViewCli, TheFinalPicture_isTheFileOfTheSavedJob) {
  const json body = {
      {"seq", 1},
      {"size", {80, 60}},
      {"job", {{"kiln", 2}, {"transferFunction", "ct-skin"}, {"look", "studio"}, {"camera", {{"view", "left"}}}}}};
  std::string final;
  bool asked = false;
  ToolOptions options;
  options.directory = directory_;
  options.interrupt_at = [&](const ToolResult& so_far) {
    const auto viewer = Viewer::of(so_far.out);
    if (!viewer || asked) return asked;
    asked = true;
    final = payloadOf(viewer->answerTo("frame", body), "final");
    EXPECT_EQ(statusOf(viewer->answerTo("save", body)), 200);
    return true;
  };
  const ToolResult ended = done({"view", "h.kiln", "--tf", "ct-bone", "--no-browser"}, options);
  EXPECT_FALSE(ended.timed_out);
  EXPECT_EQ(ended.err.find("warning"), std::string::npos) << ended.err;
  options.interrupt_at = nullptr;
  done({"render", "h.view.json", "-o", "x.png"}, options);
  EXPECT_GT(final.size(), 1000u);
  EXPECT_EQ(final, textOf(readFile(directory_ / "x.png")));
}

TEST_F(ViewCli, AJobWithATrace_isShown_andWritesNone) {
  writeText(in("job.json"), json{{"kiln", 2}, {"volume", "h.kiln"}, {"trace", "trace.json"}}.dump());
  ToolOptions options;
  options.directory = directory_;
  options.interrupt_at = [](const ToolResult& so_far) { return Viewer::of(so_far.out).has_value(); };
  done({"view", "job.json", "--no-browser"}, options);
  EXPECT_FALSE(std::filesystem::exists(in("trace.json")));
}

TEST_F(ViewCli, Signals_endTheViewer) {
  runScript(directory_, R"sh(
await() { for i in $(seq 200); do if [ -S "$1" ]; then return 0; fi; sleep 0.05; done; return 1; }
# A viewer that ignores SIGHUP from the start, as under nohup, continues to do so.
viewer() { exec env --default-signal=HUP kiln view "$@"; }
for signal in TERM INT HUP; do
  viewer ../h.kiln --socket one.sock & one=$!
  viewer ../h.kiln --socket two.sock --tf iso:300 & two=$!
  await one.sock
  await two.sock
  [ "$(stat -c %a one.sock)" = 600 ]
  kill -$signal $one $two
  wait $one
  wait $two
  [ ! -e one.sock ] && [ ! -e two.sock ]
done
# The socket of a viewer that was killed is replaced.
kiln view ../h.kiln --socket one.sock & one=$!
await one.sock
kill -KILL $one
wait $one || true
[ -S one.sock ]
kiln view ../h.kiln --socket one.sock > out.txt & one=$!
for i in $(seq 200); do if grep -q ssh out.txt; then break; fi; sleep 0.05; done
grep -q 'http://localhost:8000/#' out.txt
kill -TERM $one
wait $one
[ ! -e one.sock ]
)sh");
}

// An SSH server of the test's own on 127.0.0.1, with keys of the test. Known: the forwarded port answers as the socket.
TEST_F(ViewCli, ASocket_isReachedThroughSsh) {
  if (!std::filesystem::exists("/usr/sbin/sshd")) GTEST_SKIP() << "needs the package openssh-server";
  runScript(directory_, R"sh(
await() { for i in $(seq 200); do if "$@"; then return 0; fi; sleep 0.05; done; return 1; }
freePort() { python3 -c 'import socket; s = socket.socket(); s.bind(("127.0.0.1", 0)); print(s.getsockname()[1])'; }
ssh-keygen -q -t ed25519 -N '' -f host
ssh-keygen -q -t ed25519 -N '' -f user
cat > sshd.conf <<EOF
HostKey $PWD/host
AuthorizedKeysFile $PWD/user.pub
PidFile none
StrictModes no
UsePAM no
PermitRootLogin prohibit-password
EOF
# The server's own directory, which the system's service makes.
if [ "$(id -u)" = 0 ]; then mkdir -p -m 755 /run/sshd; fi
server=$(freePort) port=$(freePort) three=
/usr/sbin/sshd -D -e -f "$PWD/sshd.conf" -o ListenAddress=127.0.0.1 -p "$server" 2> sshd.log & one=$!
# The name of a socket has at most 107 bytes.
folder=$(mktemp -d)
kiln view ../h.kiln --socket "$folder/v" > out.txt & two=$!
trap 'kill $one $two $three 2> /dev/null; wait $two; rm -r "$folder"' EXIT
await test -S "$folder/v"
await grep -q "listening" sshd.log
ssh -N -F none -i user -p "$server" -o StrictHostKeyChecking=no -o UserKnownHostsFile=/dev/null -o BatchMode=yes \
  -o ExitOnForwardFailure=yes -L "127.0.0.1:$port:$folder/v" 127.0.0.1 2> ssh.log & three=$!
await grep -q '#' out.txt
token=$(sed -n 's|.*localhost:8000/#||p' out.txt)
cat > ask.py <<'EOF'
import http.client, json, sys, time
def answer(port, token):
    link = http.client.HTTPConnection("localhost", port, timeout=60)
    body = json.dumps({"seq": 1, "size": [64, 48], "job": {"kiln": 2}})
    link.request("POST", "/api/frame", body, {"Authorization": "Bearer " + token, "Content-Type": "application/json"})
    found = link.getresponse()
    return found.status, found.read()
for _ in range(200):
    try:
        status, records = answer(int(sys.argv[1]), sys.argv[2])
        break
    except OSError:
        time.sleep(0.05)
assert status == 200 and b'"stage":"final"' in records and b"PNG" in records, (status, records[:200])
assert answer(int(sys.argv[1]), "0" * 32)[0] == 401
EOF
python3 ask.py "$port" "$token" || { cat sshd.log ssh.log >&2; exit 1; }
)sh");
}

TEST_F(ViewCli, WrongOptions_areRefused) {
  writeText(in("file"), "here");
  // The name of a socket has at most 107 bytes, which the folder of the tests may exceed.
  const ToolResult file = runTool({"view", in("h.kiln"), "--socket", "file"}, {.directory = directory_});
  EXPECT_EQ(file.exit_code, 1);
  EXPECT_NE(file.err.find("is a file already"), std::string::npos) << file.err;
  refused({"view", in("h.kiln"), "--socket", in("s"), "--port", "8000"}, 2, "--socket: contradicts --port");
  refused({"view", in("h.kiln"), "--job", in("look.txt")}, 2, "must end in .json");
  refused({"view", in("h.kiln"), "--job", in("h.kiln/look.json")}, 2, "--job");
  writeText(in("tf.json"), done({"tf", "ct-bone", "--json"}).out);
  refused({"view", in("h.kiln"), "--tf", in("tf.json"), "--job", in("tf.json")}, 2, "which this command reads");
  refused({"view", in("none.kiln")}, 1, "none.kiln");
  refused({"view", in("h.kiln"), "--trace", in("t.json")}, 2, "--trace");
  EXPECT_EQ(done({"view", "--help"}).out.find("--trace"), std::string::npos);
  refused({"view", in("h.kiln"), "--memory", "1M"}, 1, "--memory");
  refused({"view", in("h.kiln"), "--port", "70000"}, 2, "--port");
  for (const char* const name : {"https://hub.example", "hub.example:443", "hub.example/user", "[::1]:443"})
    refused({"view", in("h.kiln"), "--allow-host", name}, 2, "--allow-host: expected a name without scheme, port");
  refused({"view", in("h.kiln"), "--part", "1/2"}, 2, "--part");
  EXPECT_EQ(readFile(in("file")).size(), 4u);
}

}  // namespace
}  // namespace kiln::test
