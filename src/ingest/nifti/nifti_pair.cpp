#include "ingest/nifti/nifti_pair.h"

#include <system_error>

#include "base/text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

const char* endingOf(PairFile file) { return file == PairFile::kHeader ? ".hdr" : ".img"; }

}  // namespace

bool endsInGz(const fs::path& path) { return lowered(path.extension().string()) == ".gz"; }

bool isNamed(PairFile file, const fs::path& path) {
  return lowered((endsInGz(path) ? path.stem() : path.filename()).extension().string()) == endingOf(file);
}

fs::path besideInPair(PairFile file, const fs::path& other) {
  fs::path stem = endsInGz(other) ? fs::path(other).replace_extension() : other;
  stem.replace_extension();
  const std::string lower = endingOf(file), upper = file == PairFile::kHeader ? ".HDR" : ".IMG";
  for (const char* const packed : {"", ".gz", ".GZ"}) {
    for (const std::string& ending : {lower, upper}) {
      std::error_code unknown;
      if (const fs::path name = stem.string() + ending + packed; fs::exists(name, unknown)) return name;
    }
  }
  return stem.string() + lower;
}

}  // namespace kiln
