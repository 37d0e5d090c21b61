// The HTTP server of a viewing session, in a module of its own: programs that do not view load no HTTP.
//
// Security. The server listens on the loopback interface or on a socket of mode 0600. Every request of the session
// needs a random token of 128 bits, which no other page can send. The token stands in the fragment of the address, and
// so in no log. Names of hosts and origins are tested against DNS rebinding. The only files are compiled in.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "view/view_client.h"

namespace kiln {

struct ViewServerOptions {
  std::uint16_t port = 0;          // on 127.0.0.1; 0: any free port
  std::filesystem::path socket{};  // if not empty, a UNIX socket instead of a port
  /// Further names of this server, behind a proxy.
  std::vector<std::string> hosts{};
  bool framed = false;  // pages of this machine, such as notebooks, may show the page in a frame
  /// Most time for a request's header, for a whole request, and without progress of an answer. unit: seconds.
  double header_s = 10, request_s = 30;
  int connections = 8;  // at a time; further ones are refused at once
};

class ViewServer {
 public:
  virtual ~ViewServer() = default;
  /// The address to open in a browser, with the token.
  virtual std::string address() const = 0;
  virtual std::uint16_t port() const = 0;
  virtual const std::string& token() const = 0;
  /// Serves until `stopped()`, which is asked ten times a second. Then ends all requests.
  virtual void run(const std::function<bool()>& stopped) = 0;
};

/// Loads the module and binds the address. requires: `service` outlives the server. throws: Error kUnsupported without
/// the module, kIo, kExists for a socket's path that another file or a running server has.
std::unique_ptr<ViewServer> makeViewServer(ViewService& service, const ViewServerOptions& options);

}  // namespace kiln
