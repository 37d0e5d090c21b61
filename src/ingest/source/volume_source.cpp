#include "ingest/source/volume_source.h"

#include "ingest/source/formats.h"

namespace kiln {

std::string namedNote(const SourceInfo& info, const std::string& note) {
  if (info.files.empty()) return note;
  const std::filesystem::path& opened = info.files.front();
  const std::string own = opened.filename().string() + ": ";
  return opened.string() + ": " + (note.starts_with(own) ? note.substr(own.size()) : note);
}

bool namesPhantom(const std::filesystem::path& input) { return input.string().starts_with(kPhantomScheme); }

}  // namespace kiln
