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

std::string extentOf(const DicomPixels& p) { return fmt::format("{} x {}", p.columns, p.rows); }

// The pixels of most slices of a series.
struct Majority {
  std::string extent;  // "512 x 512"
  std::int64_t slices = 0;
  bool readable = false;
};

// Why the object is none of these slices; empty where it is one.
std::string reasonAgainst(const DicomHeader& header, const Majority& most) {
  if (!header.has_pixels) return "has no pixel data";
  if (extentOf(header.pixels) != most.extent)
    return fmt::format("is {} pixels where {} slices of its series are {}", extentOf(header.pixels), most.slices,
                       most.extent);
  return most.readable ? header.refusal : "";
}

// Slices of one size are of one type, and can be read.
void requireAlike(const DicomHeader& header, const DicomHeader& first) {
  if (!header.refusal.empty()) throw Error(ErrorCode::kUnsupported, header.path, "", header.refusal);
  const DicomPixels &a = header.pixels, &b = first.pixels;
  if (a.storedType() == b.storedType()) return;
  throw Error(ErrorCode::kFormat, header.path, "",
              fmt::format("is {} of {}, but {} is {} of {}; slices of one volume are alike", extentOf(a),
                          nameOf(a.storedType()), first.path.filename().string(), extentOf(b), nameOf(b.storedType())));
}

// The extent that most slices have that can be read, or, where none can be read, most of all. throws: Error kFormat
// where two extents are equally frequent.
Majority majorityOf(const std::vector<DicomHeader>& all, const std::string& series) {
  std::map<std::string, std::int64_t> readable, refused;
  for (const DicomHeader& header : all) {
    if (header.series != series || !header.has_pixels) continue;
    (header.refusal.empty() ? readable : refused)[extentOf(header.pixels)] += header.pixels.frames;
  }
  const auto& extents = readable.empty() ? refused : readable;
  const auto fewer = [](const auto& a, const auto& b) { return a.second < b.second; };
  const auto most = std::max_element(extents.begin(), extents.end(), fewer);
  for (const auto& [extent, slices] : extents) {
    if (extent != most->first && slices == most->second)
      throw Error(ErrorCode::kFormat, all.front().path, "",
                  fmt::format("its series has {} slice{} of {} pixels and as many of {}; put them apart", slices,
                              slices == 1 ? "" : "s", most->first, extent));
  }
  return {most->first, most->second, !readable.empty()};
}

// Objects that are no slices, by their reasons.
class PassedOver {
 public:
  void add(const DicomHeader& header, const std::string& reason) { files_[reason].push_back(&header); }
  void note(std::vector<std::string>& notes) const {
    for (const auto& [reason, files] : files_) {
      const std::string modality = files.front()->modality.empty() ? "" : " (" + files.front()->modality + ")";
      const std::string more = files.size() == 1 ? "" : fmt::format(" and {} more", files.size() - 1);
      notes.push_back(fmt::format("passed over {}{}{}: {}", inQuotes(files.front()->path.filename().string()), modality,
                                  more, reason));
    }
  }

 private:
  std::map<std::string, std::vector<const DicomHeader*>> files_;
};

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
  const Majority most = majorityOf(all, chosen);
  PassedOver passed_over;
  std::vector<std::size_t> taken;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const DicomHeader& header = all[i];
    const bool of_series = header.series == chosen;
    if (!of_series && header.has_pixels) continue;
    // A slice that is cut short in front of its pixels.
    if (of_series && header.is_image && !header.has_pixels)
      throw Error(ErrorCode::kFormat, header.path, "", "has no pixel data, but is of the series");
    if (const std::string reason = reasonAgainst(header, most); !reason.empty())
      passed_over.add(header, reason);
    else
      taken.push_back(i);
  }
  passed_over.note(notes);
  std::vector<DicomHeader> out;
  for (const std::size_t i : taken) {
    requireAlike(all[i], out.empty() ? all[i] : out.front());
    out.push_back(std::move(all[i]));
  }
  if (series.size() > 1) notes.push_back(fmt::format("passed over {} other series", series.size() - 1));
  return out;
}

}  // namespace kiln
