#include "standard_output.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <system_error>
#include <vector>

#include "base/error.h"
#include "base/file/file.h"
#include "image/file/image_file.h"
#include "say.h"

namespace kiln::tool {
namespace fs = std::filesystem;
namespace {

constexpr std::uint64_t kCopiedBytes = 1 << 20;  // at a time

}  // namespace

bool isStandardOutputName(const fs::path& name) {
  return name == "-" || (!name.has_parent_path() && name.stem() == "-" && pictureFormatOf(name));
}

StandardOutput::~StandardOutput() {
  std::error_code ignored;
  if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

void StandardOutput::take(OutputOptions& output) {
  if (!isStandardOutputName(output.path)) return;
  if (::isatty(STDOUT_FILENO) != 0)
    throw Error(ErrorCode::kUsage,
                "-o -: standard output is a terminal, which shows no picture; write it to a file or a program, as in "
                "kiln render … -o - > picture.png");
  sayToStandardError();
  // A closed pipe is an error of writing, after which the folder is removed.
  std::signal(SIGPIPE, SIG_IGN);
  std::string name = (temporaryFolder() / "kiln-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) throw systemError(errno, name, "making a folder for a picture");
  folder_ = name;
  file_ = folder_ / ("standard-output" + (output.path == "-" ? ".png" : output.path.extension().string()));
  output.path = file_;
}

void StandardOutput::copy() const {
  if (!taken()) return;
  const File file(file_);
  std::vector<std::byte> piece;
  for (std::uint64_t at = 0; at < file.size(); at += piece.size()) {
    piece.resize(static_cast<std::size_t>(std::min(kCopiedBytes, file.size() - at)));
    file.readAt(at, piece);
    for (std::size_t done = 0; done < piece.size();) {
      const ssize_t count = ::write(STDOUT_FILENO, piece.data() + done, piece.size() - done);
      if (count < 0 && errno != EINTR) throw systemError(errno, "standard output", "writing");
      done += static_cast<std::size_t>(std::max<ssize_t>(count, 0));
    }
  }
}

}  // namespace kiln::tool
