// Users export whole examinations into one directory: scouts, reconstructions, reports. A series is one volume,
// selected by its unique identifier; if there are several series, the user must choose.
#include "ingest/dicom/dicom_series.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>

#include "base/error.h"
#include "ingest/dicom/dicom_segmentation.h"
#include "ingest/source/formats.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

struct Series {
  const DicomHeader* first = nullptr;
  std::int64_t slices = 0, objects = 0;
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

std::map<std::string, Series> seriesOf(const std::vector<DicomHeader>& all) {
  std::map<std::string, Series> out;
  for (const DicomHeader& header : all) {
    if (!header.has_pixels) continue;
    Series& entry = out[header.series];
    if (entry.first == nullptr) entry.first = &header;
    entry.slices += header.pixels.frames;
    ++entry.objects;
  }
  return out;
}

// Returns the reason of the damage without the path and the remedy.
std::string damageOf(const DicomHeader& header) {
  std::string text = header.damage->what();
  const std::string prefix = header.path.string() + ": ";
  if (text.starts_with(prefix)) text.erase(0, prefix.size());
  return "cannot be read (" + text.substr(0, text.find(';')) + ")";
}

// Names the first damaged file, for the end of a sentence; empty if no file is damaged.
std::string damagedAmong(const std::vector<DicomHeader>& all) {
  const auto damaged = [](const DicomHeader& header) { return header.damage.has_value(); };
  const auto first = std::find_if(all.begin(), all.end(), damaged);
  if (first == all.end()) return {};
  const auto count = std::count_if(first, all.end(), damaged);
  return fmt::format("; {}{} {}", inQuotes(first->path.filename().string()),
                     count == 1 ? "" : fmt::format(" (and {} more)", count - 1), damageOf(*first));
}

std::string theSeries(const fs::path& input, const std::map<std::string, Series>& series,
                      const std::vector<DicomHeader>& all, const SourceOptions& options) {
  if (options.series) {
    if (series.contains(*options.series)) return *options.series;
    throw Error(ErrorCode::kUsage, input, "",
                fmt::format("--series {}: is not among the series here: {}{}", *options.series, listOf(series),
                            damagedAmong(all)));
  }
  if (series.size() == 1) return series.begin()->first;
  throw Error(
      ErrorCode::kUsage, input, "",
      fmt::format("holds {} series; choose one with --series: {}{}", series.size(), listOf(series), damagedAmong(all)));
}

std::string extentOf(const DicomPixels& p) { return fmt::format("{} x {}", p.columns, p.rows); }

// The most frequent extent among the slices of a series.
struct Majority {
  std::string extent;  // "512 x 512"
  std::int64_t slices = 0;
  bool readable = false;
};

// Returns the reason why the object is not a slice of the majority; empty if it is one.
std::string reasonAgainst(const DicomHeader& header, const Majority& most) {
  if (!header.has_pixels) return "has no pixel data";
  if (extentOf(header.pixels) != most.extent)
    return fmt::format("is {} pixels where {} slices of its series are {}", extentOf(header.pixels), most.slices,
                       most.extent);
  return most.readable ? header.refusal : "";
}

// Returns one file of the rarest kind and one file of the most frequent kind, if `kind` differs among the files.
template <class Kind>
std::optional<std::pair<const DicomHeader*, const DicomHeader*>> oddAndUsual(const std::vector<DicomHeader>& files,
                                                                             const Kind& kind) {
  std::map<decltype(kind(files.front())), std::vector<const DicomHeader*>> kinds;
  for (const DicomHeader& file : files) kinds[kind(file)].push_back(&file);
  if (kinds.size() < 2) return std::nullopt;
  // On a tie the later file is the odd one.
  const auto rarer = [](const auto& a, const auto& b) {
    const auto &x = a.second, &y = b.second;
    return x.size() != y.size() ? x.size() < y.size() : x.front() > y.front();
  };
  const auto [odd, usual] = std::minmax_element(kinds.begin(), kinds.end(), rarer);
  return std::pair(odd->second.front(), usual->second.front());
}

// Refuses slices of unsupported pixels, of invalid headers, or of different types.
void requireAlike(const std::vector<DicomHeader>& files) {
  for (const DicomHeader& file : files)
    if (!file.refusal.empty()) throw Error(ErrorCode::kUnsupported, file.path, "", file.refusal);
  for (const DicomHeader& file : files)
    if (file.fault) throw *file.fault;
  const auto type = [](const DicomHeader& file) { return std::string(nameOf(file.pixels.storedType())); };
  const auto white = [](const DicomHeader& file) {
    return std::string(file.pixels.smallest_is_white ? "shows its smallest values white (MONOCHROME1)"
                                                     : "shows its smallest values black (MONOCHROME2)");
  };
  const auto fail = [](const DicomHeader& odd, const std::string& what, const DicomHeader& usual,
                       const std::string& is) {
    throw Error(ErrorCode::kFormat, odd.path, "",
                fmt::format("{}, but {} {}; slices of one volume are alike, so mend or remove it", what,
                            inQuotes(usual.path.filename().string()), is));
  };
  if (const auto found = oddAndUsual(files, type)) {
    const auto [odd, usual] = *found;
    const std::string extent = extentOf(odd->pixels);
    fail(*odd, fmt::format("is {} of {}", extent, type(*odd)), *usual,
         fmt::format("is {} of {}", extent, type(*usual)));
  }
  const auto table = [](const DicomHeader& file) {
    return std::string(file.lut ? "maps its values by a lookup table (modality LUT)" : "has no lookup table");
  };
  if (const auto found = oddAndUsual(files, table))
    fail(*found->first, table(*found->first), *found->second, table(*found->second));
  if (const auto found = oddAndUsual(files, white))
    fail(*found->first, white(*found->first), *found->second, white(*found->second));
}

// Refuses a rescaling number that some frames have and other frames lack, because the values would be wrong. A number
// equal to `otherwise` changes no values, so it may be missing elsewhere.
void requireSaid(const std::vector<DicomHeader>& files, const char* name, std::optional<double> DicomFrame::*number,
                 double otherwise, const SourceOptions& options, std::vector<std::string>& notes) {
  const auto says = [&](const DicomHeader& file, bool said) {
    return std::any_of(file.frames.begin(), file.frames.end(), [&](const DicomFrame& frame) {
      return said ? (frame.*number).value_or(otherwise) != otherwise : !(frame.*number).has_value();
    });
  };
  const auto with = std::find_if(files.begin(), files.end(), [&](const DicomHeader& f) { return says(f, true); });
  const auto without = std::find_if(files.begin(), files.end(), [&](const DicomHeader& f) { return says(f, false); });
  if (with == files.end() || without == files.end()) return;
  const auto found = std::find_if(with->frames.begin(), with->frames.end(), [&](const DicomFrame& frame) {
    return (frame.*number).value_or(otherwise) != otherwise;
  });
  const auto count = std::count_if(files.begin(), files.end(), [&](const DicomHeader& f) { return says(f, false); });
  const std::string what = fmt::format(
      "has no {}{}, but {} has {:g}", name, count == 1 ? "" : fmt::format(" (nor have {} others)", count - 1),
      with == without ? "another frame of it" : inQuotes(with->path.filename().string()), *((*found).*number));
  if (!options.allow_irregular)
    throw Error(ErrorCode::kFormat, without->path, "",
                fmt::format("{}; mend or remove it, or --allow-irregular takes {:g} there", what, otherwise));
  notes.push_back(fmt::format("{} {}; took {:g} there", inQuotes(without->path.filename().string()), what, otherwise));
}

void requireScaledAlike(const std::vector<DicomHeader>& files, const SourceOptions& options,
                        std::vector<std::string>& notes) {
  requireSaid(files, "RescaleIntercept (0028,1052)", &DicomFrame::intercept, 0, options, notes);
  requireSaid(files, "RescaleSlope (0028,1053), or one of 0", &DicomFrame::slope, 1, options, notes);
  const auto zero = std::find_if(files.begin(), files.end(), [](const DicomHeader& file) {
    return std::any_of(file.frames.begin(), file.frames.end(), [](const DicomFrame& f) { return f.slope_is_zero; });
  });
  if (zero != files.end())
    notes.push_back(fmt::format("{}: RescaleSlope (0028,1053) is 0, which no value survives; 1 is taken",
                                inQuotes(zero->path.filename().string())));
}

// Returns the most frequent extent among readable slices, or among all slices if none is readable.
// throws: Error kFormat if two extents are equally frequent.
Majority majorityOf(const std::vector<DicomHeader>& all, const std::string& series, const fs::path& input) {
  std::map<std::string, std::int64_t> readable, refused;
  std::map<std::string, std::string> first;
  for (const DicomHeader& header : all) {
    if (header.series != series || !header.has_pixels) continue;
    (header.refusal.empty() ? readable : refused)[extentOf(header.pixels)] += header.pixels.frames;
    first.emplace(extentOf(header.pixels), inQuotes(header.path.filename().string()));
  }
  const auto& extents = readable.empty() ? refused : readable;
  const auto fewer = [](const auto& a, const auto& b) { return a.second < b.second; };
  const auto most = std::max_element(extents.begin(), extents.end(), fewer);
  for (const auto& [extent, slices] : extents) {
    if (extent != most->first && slices == most->second)
      throw Error(
          ErrorCode::kFormat, input, "",
          fmt::format("its series has {} slice{} of {} pixels (as {}) and as many of {} (as {}); put them apart",
                      slices, slices == 1 ? "" : "s", most->first, first[most->first], extent, first[extent]));
  }
  return {most->first, most->second, !readable.empty()};
}

// Objects that are not slices, grouped by reason.
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

std::vector<DicomHeader> headersOf(const std::vector<fs::path>& files) {
  std::vector<DicomHeader> out;
  out.reserve(files.size());
  for (const fs::path& path : files) out.push_back(readDicomHeader(path));
  return out;
}

// The headers among `all` that readSeries returns.
std::vector<DicomHeader> chosenSeries(const fs::path& input, std::vector<DicomHeader> all, const SourceOptions& options,
                                      std::vector<std::string>& notes) {
  const std::map<std::string, Series> series = seriesOf(all);
  for (const DicomHeader& header : all) {
    if (header.damage && (series.empty() || header.series == options.series)) throw *header.damage;
  }
  if (series.empty()) {
    throw Error(ErrorCode::kUnsupported, all.front().path, "",
                "has no pixel data; it is a DICOM file of another kind than an image");
  }
  const std::string chosen = theSeries(input, series, all, options);
  const Majority most = majorityOf(all, chosen, input);
  PassedOver passed_over;
  std::vector<std::size_t> taken;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const DicomHeader& header = all[i];
    const bool of_series = header.series == chosen;
    if (!of_series && header.has_pixels) continue;
    if (header.damage) {
      if (of_series) throw *header.damage;
      passed_over.add(header, damageOf(header));
      continue;
    }
    // An image of the series without pixels is a slice that is cut short.
    if (of_series && header.is_image && !header.has_pixels)
      throw Error(ErrorCode::kFormat, header.path, "", "has no pixel data, but is of the series");
    if (const std::string reason = reasonAgainst(header, most); !reason.empty())
      passed_over.add(header, reason);
    else
      taken.push_back(i);
  }
  passed_over.note(notes);
  std::vector<DicomHeader> out;
  for (const std::size_t i : taken) out.push_back(std::move(all[i]));
  requireAlike(out);
  requireScaledAlike(out, options, notes);
  for (std::size_t i = 1; i < out.size(); ++i)
    if (out[i].lut && *out[i].lut == *out[i - 1].lut) out[i].lut = out[i - 1].lut;
  if (series.size() > 1) notes.push_back(fmt::format("passed over {} other series", series.size() - 1));
  return out;
}

// The reason why the slices of one series form no volume; empty if the slices do.
std::string reasonAgainstSlices(std::vector<DicomHeader> files, SourceOptions options) {
  options.series.reset();
  const fs::path folder = files.front().path.parent_path();
  std::vector<std::string> notes;
  std::vector<DicomSlice> slices;
  try {
    files = chosenSeries(folder, std::move(files), options, notes);
    arrangeSlices(folder, files, options, slices, notes);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

// A segmentation object is a volume of its own, whose planes decide its size.
ListedVolume listed(const DicomHeader& first, std::int64_t slices) {
  ListedVolume out;
  out.name = first.series.empty() ? "none" : first.series;
  out.kind = fmt::format("{} {}", first.modality, inQuotes(first.description));
  out.dims = Extent3{first.pixels.columns, first.pixels.rows, slices};
  out.refusal = first.refusal;
  if (!out.refusal.empty()) return out;
  out.type = first.pixels.storedType();
  try {
    if (first.fault) throw *first.fault;
    if (!first.segments.empty()) out.dims = segmentationDims(first);
  } catch (const Error& error) {
    out.refusal = error.what();
  }
  return out;
}

}  // namespace

std::vector<DicomHeader> readSeries(const SliceFiles& input, const SourceOptions& options,
                                    std::vector<std::string>& notes) {
  return chosenSeries(input.input, headersOf(input.files), options, notes);
}

std::vector<ListedVolume> listDicom(const std::vector<fs::path>& files, const SourceOptions& options) {
  const std::vector<DicomHeader> all = headersOf(files);
  const std::map<std::string, Series> series = seriesOf(all);
  std::vector<ListedVolume> out;
  for (const DicomHeader& header : all) {
    if (!header.damage) continue;
    if (series.empty()) throw *header.damage;
    ListedVolume damaged;
    damaged.name = header.path.filename().string();
    damaged.kind = "file";
    damaged.refusal = header.damage->what();
    out.push_back(std::move(damaged));
  }
  for (const auto& [uid, entry] : series) {
    if (entry.objects > 1 && !entry.first->segments.empty()) {
      for (const DicomHeader& object : all) {
        if (object.series != uid || !object.has_pixels) continue;
        out.push_back(listed(object, object.pixels.frames));
        if (out.back().refusal.empty()) out.back().option = object.path.string();
      }
      continue;
    }
    out.push_back(listed(*entry.first, entry.slices));
    if (series.size() > 1 && !uid.empty()) out.back().option = "--series " + uid;
    if (!out.back().refusal.empty() || !entry.first->segments.empty()) continue;
    std::vector<DicomHeader> whole;
    std::copy_if(all.begin(), all.end(), std::back_inserter(whole),
                 [&](const DicomHeader& header) { return header.series == uid && !header.damage; });
    if (!whole.empty()) out.back().refusal = reasonAgainstSlices(std::move(whole), options);
  }
  return out;
}

}  // namespace kiln
