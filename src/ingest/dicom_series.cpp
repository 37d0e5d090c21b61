// People export whole examinations into one directory: scouts, reconstructions, reports. A series is one volume or
// none, so its unique identifier decides, and where there are several the user does.
#include "ingest/dicom_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/error.h"
#include "ingest/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

struct Series {
  const DicomHeader* first = nullptr;
  std::int64_t slices = 0;
};

std::string listOf(const std::map<std::string, Series>& series) {
  constexpr std::size_t kMost = 12;
  std::string out;
  std::size_t listed = 0;
  for (const auto& [uid, s] : series) {
    if (listed++ == kMost) return out + fmt::format(", and {} more", series.size() - kMost);
    out += fmt::format("{}{} ({} {}, {} {})", listed == 1 ? "" : ", ", uid.empty() ? "none" : uid, s.first->modality,
                       inQuotes(s.first->description), s.slices, s.slices == 1 ? "slice" : "slices");
  }
  return out;
}

std::string theSeries(const fs::path& input, const std::map<std::string, Series>& series,
                      const SourceOptions& options) {
  if (options.series) {
    if (series.contains(*options.series)) return *options.series;
    throw Error(ErrorCode::kUsage, input, "",
                fmt::format("--series {}: is not among the series here: {}", *options.series, listOf(series)));
  }
  if (series.size() == 1) return series.begin()->first;
  throw Error(ErrorCode::kUsage, input, "",
              fmt::format("holds {} series; choose one with --series: {}", series.size(), listOf(series)));
}

void requireAlike(const DicomHeader& header, const DicomHeader& first) {
  if (!header.refusal.empty()) throw Error(ErrorCode::kUnsupported, header.path, "", header.refusal);
  const DicomPixels &a = header.pixels, &b = first.pixels;
  const auto describe = [](const DicomPixels& p) {
    return fmt::format("{} x {} of {}", p.columns, p.rows, nameOf(p.storedType()));
  };
  if (a.columns == b.columns && a.rows == b.rows && a.storedType() == b.storedType()) return;
  throw Error(ErrorCode::kFormat, header.path, "",
              fmt::format("is {}, but {} is {}; slices of one volume are alike", describe(a),
                          first.path.filename().string(), describe(b)));
}

}  // namespace

std::vector<DicomHeader> readSeries(const SliceFiles& input, const SourceOptions& options,
                                    std::vector<std::string>& notes) {
  std::vector<DicomHeader> all;
  all.reserve(input.files.size());
  for (const fs::path& path : input.files) all.push_back(readDicomHeader(path));
  std::map<std::string, Series> series;
  for (const DicomHeader& header : all) {
    if (!header.has_pixels) continue;
    Series& entry = series[header.series];
    if (entry.first == nullptr) entry.first = &header;
    entry.slices += header.pixels.frames;
  }
  if (series.empty()) {
    throw Error(ErrorCode::kUnsupported, all.front().path, "",
                "has no pixel data; it is a DICOM file of another kind than an image");
  }
  const std::string chosen = theSeries(input.input, series, options);
  std::vector<DicomHeader> out;
  std::size_t without = 0;
  const fs::path* example = nullptr;
  for (DicomHeader& header : all) {
    if (header.series == chosen) {
      if (!header.has_pixels)
        throw Error(ErrorCode::kFormat, header.path, "", "has no pixel data, but is of the series");
      requireAlike(header, out.empty() ? header : out.front());
      out.push_back(std::move(header));
    } else if (!header.has_pixels && without++ == 0) {
      example = &header.path;
    }
  }
  if (without > 0) {
    notes.push_back(fmt::format("passed over {}{}, which {} no pixel data", inQuotes(example->filename().string()),
                                without == 1 ? "" : fmt::format(" and {} more", without - 1),
                                without == 1 ? "has" : "have"));
  }
  if (series.size() > 1) notes.push_back(fmt::format("passed over {} other series", series.size() - 1));
  return out;
}

}  // namespace kiln
