#include "tool_call.h"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <sstream>
#include <stdexcept>

namespace kiln::test {
namespace {

constexpr std::size_t kMostRequestBytes = 128 << 10;  // below what a socket accepts
using Descriptors = std::array<int, 4>;               // standard input, output, error, the socket for the answers

// Variables of this process and, after them, those of the call.
std::vector<std::string> environmentOf(const ToolCall& call) {
  std::vector<std::string> out;
  for (char** variable = environ; *variable != nullptr; ++variable) out.emplace_back(*variable);
  out.insert(out.end(), call.environment.begin(), call.environment.end());
  return out;
}

// A request: numbers of arguments and variables, limits, the directory, then all arguments and variables, each ended by
// NUL.
std::string requestOf(const ToolCall& call) {
  std::ostringstream out;
  const auto put = [&](const std::string& text) { out << text << '\0'; };
  const std::vector<std::string> environment = environmentOf(call);
  for (const std::uint64_t number : {std::uint64_t{call.arguments.size()}, std::uint64_t{environment.size()},
                                     call.file_bytes, call.open_files, call.more_address_bytes})
    put(std::to_string(number));
  put((call.directory.empty() ? std::filesystem::current_path() : call.directory).string());
  for (const std::string& argument : call.arguments) put(argument);
  for (const std::string& variable : environment) put(variable);
  return std::move(out).str();
}

ToolCall callOf(const std::string& request) {
  std::istringstream in(request);
  const auto next = [&] {
    std::string text;
    std::getline(in, text, '\0');
    return text;
  };
  ToolCall out{};
  out.arguments.resize(std::stoull(next()));
  out.environment.resize(std::stoull(next()));
  for (std::uint64_t* limit : {&out.file_bytes, &out.open_files, &out.more_address_bytes}) *limit = std::stoull(next());
  out.directory = next();
  for (std::string& argument : out.arguments) argument = next();
  for (std::string& variable : out.environment) variable = next();
  return out;
}

void sendRequest(int socket, const std::string& request, const Descriptors& descriptors) {
  iovec bytes{const_cast<char*>(request.data()), request.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(Descriptors))> control{};
  msghdr message{};
  message.msg_iov = &bytes, message.msg_iovlen = 1;
  message.msg_control = control.data(), message.msg_controllen = control.size();
  cmsghdr* const header = CMSG_FIRSTHDR(&message);
  header->cmsg_level = SOL_SOCKET, header->cmsg_type = SCM_RIGHTS, header->cmsg_len = CMSG_LEN(sizeof(Descriptors));
  std::memcpy(CMSG_DATA(header), descriptors.data(), sizeof(Descriptors));
  if (request.size() > kMostRequestBytes || ::sendmsg(socket, &message, MSG_NOSIGNAL) < 0)
    throw std::runtime_error("the server of the program takes no request");
}

}  // namespace

CalledTool::CalledTool(int socket) : socket_(socket), process_(-1) {
  if (::recv(socket_, &process_, sizeof process_, 0) != sizeof process_ || process_ < 0) {
    ::close(socket_);
    throw std::runtime_error("the server of the program starts no process");
  }
}

CalledTool::~CalledTool() { ::close(socket_); }

ToolEnd CalledTool::wait() const {
  ToolEnd end{};
  ssize_t got;
  do got = ::recv(socket_, &end, sizeof end, 0);
  while (got < 0 && errno == EINTR);
  if (got != sizeof end) throw std::runtime_error("the server of the program has ended");
  return end;
}

CalledTool callTool(int server, const ToolCall& call) {
  std::array<int, 2> answers{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, answers.data()) != 0)
    throw std::runtime_error("socketpair failed");
  try {
    sendRequest(server, requestOf(call), {call.in, call.out, call.err, answers[1]});
  } catch (...) {
    for (const int end : answers) ::close(end);
    throw;
  }
  ::close(answers[1]);
  return CalledTool(answers[0]);
}

bool receiveCall(int server, ReceivedCall& out) {
  std::string request(kMostRequestBytes, '\0');
  iovec bytes{request.data(), request.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(Descriptors))> control{};
  msghdr message{};
  message.msg_iov = &bytes, message.msg_iovlen = 1;
  message.msg_control = control.data(), message.msg_controllen = control.size();
  ssize_t got;
  do got = ::recvmsg(server, &message, MSG_CMSG_CLOEXEC);
  while (got < 0 && errno == EINTR);
  const cmsghdr* const header = got > 0 ? CMSG_FIRSTHDR(&message) : nullptr;
  if (header == nullptr || header->cmsg_len != CMSG_LEN(sizeof(Descriptors))) return false;
  request.resize(static_cast<std::size_t>(got));
  Descriptors descriptors{};
  std::memcpy(descriptors.data(), CMSG_DATA(header), sizeof(Descriptors));
  out.call = callOf(request);
  out.call.in = descriptors[0], out.call.out = descriptors[1], out.call.err = descriptors[2];
  out.answers = descriptors[3];
  return true;
}

}  // namespace kiln::test
