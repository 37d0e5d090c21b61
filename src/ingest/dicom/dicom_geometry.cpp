// Problem. Each slice has its own position and orientation; a volume needs one affine.
// Method. Sort the slices by position along their normal; the affine runs from the first slice to the last. Nothing is
// resampled: slices must be parallel and equally far apart, unless the user allows irregular slices.
// Invariant. The volume is right-handed, whatever order the scanner wrote.
// Source. DICOM PS3.3 C.7.6.2.1.1 (image plane: position, orientation and spacing to the patient's millimetres).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "base/error.h"
#include "ingest/dicom/dicom_plane.h"
#include "ingest/dicom/dicom_series.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace fs = std::filesystem;
namespace {

// Positions are decimal strings rounded to a few digits. Tolerances: relative error of a distance; tilt in radians (0.1
// degrees); offset of a slice from the line, in pixels.
constexpr double kDistanceTolerance = 0.02, kTiltTolerance = 1.75e-3, kAsideTolerance = 0.1;

class Arrangement {
 public:
  Arrangement(const fs::path& input, const std::vector<DicomHeader>& files, const SourceOptions& options,
              std::vector<DicomSlice>& slices, std::vector<std::string>& notes)
      : input_(input), files_(files), options_(options), slices_(slices), notes_(notes) {}

  VolumeGeometry run() {
    for (std::size_t i = 0; i < files_.size(); ++i) {
      for (std::int64_t f = 0; f < files_[i].pixels.frames; ++f) slices_.push_back({i, f});
    }
    VolumeGeometry out;
    const DicomPixels& pixels = files_.front().pixels;
    out.dims = {pixels.columns, pixels.rows, static_cast<std::int64_t>(slices_.size())};
    const auto placed = [&](const DicomSlice& s) { return frame(s).position && frame(s).along_row; };
    const auto count = std::count_if(slices_.begin(), slices_.end(), placed);
    if (count == 0) {
      orderByInstance();
      out.world_from_index = affineBySpacing();
      return out;
    }
    if (static_cast<std::size_t>(count) != slices_.size()) {
      fail(fmt::format("{} has no position or orientation, but others have",
                       name(*std::find_if_not(slices_.begin(), slices_.end(), placed))));
    }
    if (options_.spacing) refuseSpacing(input_);
    requireParallel();
    orderByPosition();
    out.world_from_index = affineByPosition();
    out.frame = PatientFrame::kLps;
    out.unit = "mm";
    return out;
  }

 private:
  const DicomFrame& frame(const DicomSlice& s) const {
    return files_[s.file].frames[static_cast<std::size_t>(s.frame)];
  }
  const DicomFrame& first() const { return frame(slices_.front()); }
  // The file's name, with its folders where slices lie in several.
  std::string name(const DicomHeader& file) const {
    const bool one_folder = std::all_of(files_.begin(), files_.end(), [&](const DicomHeader& other) {
      return other.path.parent_path() == files_.front().path.parent_path();
    });
    return inQuotes((one_folder ? file.path.filename() : file.path.lexically_relative(input_)).string());
  }
  std::string name(const DicomSlice& s) const {
    const std::string file = name(files_[s.file]);
    return files_[s.file].pixels.frames == 1 ? file : fmt::format("frame {} of {}", s.frame + 1, file);
  }
  [[noreturn]] void fail(const std::string& what, ErrorCode code = ErrorCode::kFormat) const {
    throw Error(code, input_, "", what);
  }

  // Refuses equal instance numbers, except if all numbers are equal: then the number carries no information.
  void requireDifferentNumbers() const {
    std::vector<const DicomHeader*> numbered;
    for (const DicomHeader& file : files_)
      if (file.instance) numbered.push_back(&file);
    std::stable_sort(numbered.begin(), numbered.end(),
                     [](const DicomHeader* a, const DicomHeader* b) { return *a->instance < *b->instance; });
    const auto same =
        std::adjacent_find(numbered.begin(), numbered.end(),
                           [](const DicomHeader* a, const DicomHeader* b) { return *a->instance == *b->instance; });
    if (same == numbered.end() || *numbered.front()->instance == *numbered.back()->instance) return;
    fail(fmt::format("{} and {} have the same number, and no position; the series holds more than one volume (times, "
                     "echoes, phases?)",
                     name(*same[0]), name(*same[1])),
         ErrorCode::kUnsupported);
  }

  void orderByInstance() {
    const auto number = [&](const DicomSlice& s) { return files_[s.file].instance.value_or(0); };
    requireDifferentNumbers();
    // Stable sort: equal numbers keep the natural order of names, and frames keep their order in the file.
    std::stable_sort(slices_.begin(), slices_.end(),
                     [&](const DicomSlice& a, const DicomSlice& b) { return number(a) < number(b); });
    if (slices_.size() > 1) {
      notes_.push_back(
          "the DICOM files have no positions of slices; the slices are taken in the order of their instance numbers");
    }
  }

  glm::dmat4 affineBySpacing() const {
    const glm::dvec2 pixel = first().spacing.value_or(glm::dvec2(1));
    const double distance = first().distance() > 0 ? first().distance() : pixel.x;
    return axesAffine(options_.spacing.value_or(glm::dvec3(pixel, distance)), glm::dvec3(0));
  }

  void requireParallel() {
    if (const std::string fault = orientationFault(first()); !fault.empty()) fail(name(slices_.front()) + ": " + fault);
    if (!first().spacing) fail(name(slices_.front()) + " has a position, but no spacing of pixels");
    normal_ = glm::normalize(glm::cross(*first().along_row, *first().along_column));
    requireLikeFirst(isTurned, "is turned against", "slices of one volume are parallel (a scout among them?)");
    requireLikeFirst(isResized, "has pixels of another size than", "slices of one volume are alike");
  }

  // Reports the slice that differs from most slices, even if it is the first.
  template <class Differs>
  void requireLikeFirst(const Differs& differs, const char* what, const char* rule) const {
    const auto unlike = [&](const DicomSlice& s) { return differs(frame(s), first()); };
    const auto found = std::find_if(slices_.begin(), slices_.end(), unlike);
    if (found == slices_.end()) return;
    const auto count = static_cast<std::size_t>(std::count_if(found, slices_.end(), unlike));
    const bool first_is_odd = 2 * count > slices_.size();
    const DicomSlice &odd = first_is_odd ? slices_.front() : *found, &other = first_is_odd ? *found : slices_.front();
    fail(fmt::format("{} {} {}; {}", name(odd), what, name(other), rule));
  }

  double along(const DicomSlice& s) const { return glm::dot(*frame(s).position, normal_); }

  void orderByPosition() {
    std::stable_sort(slices_.begin(), slices_.end(),
                     [&](const DicomSlice& a, const DicomSlice& b) { return along(a) < along(b); });
  }

  glm::dmat4 affineByPosition() {
    const glm::dvec2 pixel = *first().spacing;
    const glm::dvec3 x = *first().along_row * pixel.x, y = *first().along_column * pixel.y;
    glm::dvec3 step = normal_ * (first().distance() > 0 ? first().distance() : pixel.x);
    if (slices_.size() > 1) {
      const bool regular = checkDistances();
      const glm::dvec3 whole = *frame(slices_.back()).position - *first().position;
      checkTilt(whole);
      checkAside(whole);
      step = regular ? whole / static_cast<double>(slices_.size() - 1) : whole * (median_ / glm::dot(whole, normal_));
    }
    return directionsAffine({x, y, step}, *first().position);
  }

  // True if all distances equal the median distance.
  bool checkDistances() {
    std::vector<double> distances;
    for (std::size_t i = 1; i < slices_.size(); ++i) distances.push_back(along(slices_[i]) - along(slices_[i - 1]));
    std::vector<double> sorted = distances;
    std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
    median_ = sorted[sorted.size() / 2];
    std::size_t irregular = 0, worst = 0;
    for (std::size_t i = 0; i < distances.size(); ++i) {
      if (distances[i] <= kDistanceTolerance * std::max(median_, 1e-9)) {
        fail(fmt::format(
                 "{} and {} lie at the same place; the series holds more than one volume (times, echoes, phases?)",
                 name(slices_[i]), name(slices_[i + 1])),
             ErrorCode::kUnsupported);
      }
      if (std::abs(distances[i] - median_) <= kDistanceTolerance * median_) continue;
      if (irregular++ == 0 || std::abs(distances[i] - median_) > std::abs(distances[worst] - median_)) worst = i;
    }
    if (irregular == 0) return true;
    const double times = distances[worst] / median_;
    const bool missing = times > 1.5 && std::abs(times - std::round(times)) <= kDistanceTolerance * times;
    const std::string what = fmt::format(
        "{} and {} are {:.6g} mm apart where others are {:.6g} mm{}{}", name(slices_[worst]), name(slices_[worst + 1]),
        distances[worst], median_, missing ? fmt::format(": {} missing between them", std::lround(times) - 1) : "",
        irregular == 1 ? "" : fmt::format(" ({} such places)", irregular));
    allow(what, fmt::format("all slices {:.6g} mm apart", median_));
    return false;
  }

  void checkTilt(const glm::dvec3& whole) {
    const double height = glm::dot(whole, normal_), aside = glm::length(whole - normal_ * height);
    const double angle = std::atan2(aside, height);
    if (angle <= kTiltTolerance) return;
    allow(fmt::format("the slices from {} to {} are tilted by {:.4g} degrees against their stack (gantry tilt)",
                      name(slices_.front()), name(slices_.back()), glm::degrees(angle)),
          "them sheared by just this");
  }

  // Tests the distance of each slice from the line between the first and the last slice.
  void checkAside(const glm::dvec3& whole) {
    const glm::dvec3 per_height = whole / glm::dot(whole, normal_);
    const double limit = kAsideTolerance * std::min(first().spacing->x, first().spacing->y);
    for (const DicomSlice& s : slices_) {
      const glm::dvec3 expected = *first().position + per_height * (along(s) - along(slices_.front()));
      const double aside = glm::length(*frame(s).position - expected);
      if (aside <= limit) continue;
      allow(fmt::format("{} lies {:.4g} mm beside the line of the others", name(s), aside), "all slices on that line");
      return;
    }
  }

  // Throws, or adds a note if the user allows irregular slices.
  void allow(const std::string& what, const std::string& taken) {
    if (!options_.allow_irregular) fail(what + passedOver() + "; --allow-irregular takes " + taken);
    notes_.push_back(what + "; took " + taken);
  }

  // Returns the first note that names a passed-over file, because that file may be the missing slice; empty without
  // such a note.
  std::string passedOver() const {
    const auto note = std::find_if(notes_.begin(), notes_.end(),
                                   [](const std::string& text) { return text.starts_with("passed over '"); });
    return note == notes_.end() ? "" : " (" + *note + ")";
  }

  const fs::path& input_;
  const std::vector<DicomHeader>& files_;
  const SourceOptions& options_;
  std::vector<DicomSlice>& slices_;
  std::vector<std::string>& notes_;
  glm::dvec3 normal_{};
  double median_ = 0;
};

}  // namespace

VolumeGeometry arrangeSlices(const fs::path& input, const std::vector<DicomHeader>& files, const SourceOptions& options,
                             std::vector<DicomSlice>& slices, std::vector<std::string>& notes) {
  VolumeGeometry out = Arrangement(input, files, options, slices, notes).run();
  requireInvertible(out.world_from_index, input.string());
  return out;
}

}  // namespace kiln
