#include "bench/report/report_csv.h"

#include <fmt/format.h>

#include "job/job_names.h"

namespace kiln {
namespace {

// Quotes a field with a comma, a quote or a line break, and doubles its quotes.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

}  // namespace

std::string measurementsCsv(const Measurements& m) {
  std::string out =
      "case,classification,width_px,height_px,projection,method,view,turn_deg,render_s,fastest_s,wall_s,load_s,"
      "voxels_visited,voxels_splats,nodes_tested,nodes_hidden,bricks_total,bricks_interesting,bricks_read,"
      "bricks_hidden,identical,pixels_off_by_more_than_1,largest_distance_255\n";
  for (const MeasuredRun& run : m.runs) {
    const SuiteCase& c = m.suite.cases[run.case_index];
    for (const FrameMeasurement& f : run.frames) {
      const FrameStatistics& s = f.frame;
      std::uint64_t off = 0;
      for (std::size_t i = 2; i < f.distance.pixels.size(); ++i) off += f.distance.pixels[i];
      out +=
          fmt::format("{},{},{},{},{},{},{},{:.4f},{:.6f},{:.6f},{:.6f},{:.6f},{},{},{},{},{},{},{},{},{},{},{:.3f}\n",
                      field(c.name), field(c.classification), run.size.width, run.size.height,
                      nameIn(kProjectionNames, run.projection), nameIn(kVisibilityNames, f.method), f.view, f.turn_deg,
                      f.render_s, f.fastest_s, s.wall_s, s.load_s, s.voxels_visited, s.voxels_splats, s.nodes_tested,
                      s.nodes_hidden, s.bricks_total, s.bricks_interesting, s.bricks_read, s.bricks_hidden,
                      f.identical ? 1 : 0, off, f.distance.largest);
    }
  }
  return out;
}

}  // namespace kiln
