// Opens an address in the user's browser.
#pragma once

#include <filesystem>
#include <string>

namespace kiln::tool {

/// A browser at an address, opened by xdg-open where a desktop is there and standard output is a terminal.
/// Arguments of programs are public and the address holds a secret: the browser gets a page of mode 0600 in
/// XDG_RUNTIME_DIR that leads to the address. Without this folder no browser is opened. Destruction removes the page.
class OpenedBrowser {
 public:
  explicit OpenedBrowser(const std::string& address);
  ~OpenedBrowser();
  OpenedBrowser(const OpenedBrowser&) = delete;
  OpenedBrowser& operator=(const OpenedBrowser&) = delete;

 private:
  std::filesystem::path page_;  // empty: none
};

/// True once the terminal of standard output is gone. False if standard output is no terminal.
bool terminalIsGone();

}  // namespace kiln::tool
