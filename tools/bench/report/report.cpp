#include "bench/report/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "base/error.h"
#include "base/file/folder.h"
#include "base/file/path_status.h"
#include "bench/report/node_slice_drawing.h"
#include "bench/report/report_csv.h"
#include "bench/report/report_figures.h"
#include "bench/report/report_html.h"
#include "bench/report/report_json.h"
#include "job/job_names.h"
#include "store/store_reader.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

constexpr std::array<std::string_view, 6> kParts = {"report.html", "report.json", "measurements.csv",
                                                    "suite.json",  "pictures",    "stores"};

// Returns a case's name as part of a file name.
std::string fileWord(const std::string& name) {
  std::string out;
  for (const char c : name) out += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return out;
}

class PictureFiles {
 public:
  PictureFiles(const Measurements& m, const fs::path& directory, FileSystem& disk)
      : m_(m), directory_(directory), disk_(disk) {}

  void write() {
    disk_.makeDirectories(directory_);
    removeEarlier();
    for (const Picture& p : m_.pictures) png("picture", p.case_index, p.projection, "", p.png);
    for (const ArtifactStudy& a : m_.artifacts) {
      png("artifacts", a.case_index, a.projection, "-exact", a.exact_png);
      png("artifacts", a.case_index, a.projection, "-quadtree", a.approximate_png);
      png("artifacts", a.case_index, a.projection, "-difference", a.difference_png);
      if (!a.difference_enough_png.empty())
        png("artifacts", a.case_index, a.projection, "-difference-enlarged", a.difference_enough_png);
    }
    for (const NodeSlice& s : m_.slices) {
      const std::string method(nameIn(kVisibilityNames, s.method));
      disk_.writeOwn(directory_ / (stem("nodes", s.case_index, s.projection) + "-" + method + ".svg"),
                     drawNodeSlice(s, m_.volumes[s.case_index]).file());
    }
  }

 private:
  // Removes pictures of an earlier suite. Other files belong to the user.
  void removeEarlier() {
    std::vector<fs::path> earlier;
    forEachEntry(directory_, [&](const fs::directory_entry& entry) {
      const std::string name = entry.path().filename().string();
      const bool ours = name.starts_with("picture-") || name.starts_with("artifacts-") || name.starts_with("nodes-");
      if (ours && (name.ends_with(".png") || name.ends_with(".svg"))) earlier.push_back(entry.path());
      return Walk::kGoOn;
    });
    for (const fs::path& path : earlier) disk_.removeAll(path);
  }
  std::string stem(std::string_view what, std::size_t case_index, Projection projection) const {
    return fmt::format("{}-{:02}-{}-{}", what, case_index, fileWord(m_.suite.cases[case_index].name),
                       nameIn(kProjectionNames, projection));
  }
  void png(std::string_view what, std::size_t case_index, Projection projection, std::string_view ending,
           const std::vector<std::byte>& data) {
    disk_.writeOwn(directory_ / (stem(what, case_index, projection) + std::string(ending) + ".png"), data);
  }

  const Measurements& m_;
  fs::path directory_;
  FileSystem& disk_;
};

}  // namespace

void requireReportDirectory(const fs::path& directory) {
  requireOutsideStores(directory, "-o");
  if (!isThere(directory)) return;
  if (!isFolder(directory)) throw Error(ErrorCode::kUsage, directory, "", "is no directory; a report is one");
  forEachEntry(directory, [&](const fs::directory_entry& entry) {
    std::string name = entry.path().filename().string();
    if (name.ends_with(".tmp")) name.resize(name.size() - 4);  // left by an interrupted atomic write
    if (std::find(kParts.begin(), kParts.end(), name) != kParts.end()) return Walk::kGoOn;
    throw Error(ErrorCode::kExists, directory, "",
                "holds '" + name +
                    "', which is no part of a report; name a directory that is new or holds an earlier "
                    "report");
  });
}

std::vector<fs::path> reportFiles(const fs::path& directory) {
  return {suiteFileOf(directory), directory / "measurements.csv", directory / "report.json", directory / "report.html"};
}

void writeReport(const Measurements& m, const fs::path& directory, FileSystem& disk) {
  disk.makeDirectories(directory);
  PictureFiles(m, directory / "pictures", disk).write();
  disk.writeOwn(suiteFileOf(directory), m.suite.text);
  disk.writeOwn(directory / "measurements.csv", measurementsCsv(m));
  disk.writeOwn(directory / "report.json", measurementsJson(m));
  disk.writeOwn(directory / "report.html", measurementsHtml(m));
}

}  // namespace kiln
