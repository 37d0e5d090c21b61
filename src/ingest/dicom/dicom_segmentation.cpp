// Problem. Writers leave out planes without a segment, and write planes once for each segment, in any order.
// Method. A frame's plane is its distance along the normal from the lowest frame, in steps of the spacing; planes
// without a frame are 0. Pixels are bits of labels, or bytes that hold fractions of one segment. Bits of all frames
// follow each other without padding, the lowest bit of a byte first.
#include "ingest/dicom/dicom_segmentation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <iterator>
#include <limits>
#include <map>
#include <set>

#include "base/error.h"
#include "base/memory/memory.h"
#include "ingest/bytes/linear_source.h"
#include "ingest/dicom/dicom_bytes.h"
#include "ingest/dicom/dicom_plane.h"
#include "ingest/source/chosen_part.h"
#include "ingest/source/header_text.h"

namespace kiln {
namespace {

// Tolerances: of heights and of gaps, in planes; of the heights of one plane, in pixels, at the least.
constexpr double kPlaneTolerance = 0.02, kGapTolerance = 0.1, kSamePlane = 1e-3;

struct SegmentFrame {
  int segment = 0;
  std::int64_t frame = 0;
};

struct SegmentPlanes {
  VolumeGeometry geometry;
  /// The frames of each plane that has any, by segment.
  std::map<std::int64_t, std::vector<SegmentFrame>> frames;
};

class PlaneFinder {
 public:
  explicit PlaneFinder(const DicomHeader& header) : header_(header), first_(header.frames.front()) {}

  SegmentPlanes run() {
    requirePlaced();
    const glm::dvec3 x = *first_.along_row, y = *first_.along_column;
    normal_ = glm::normalize(glm::cross(x, y));
    const auto lowest = std::min_element(header_.frames.begin(), header_.frames.end(),
                                         [&](const DicomFrame& a, const DicomFrame& b) { return along(a) < along(b); });
    origin_ = *lowest->position;
    const double step = spacing();
    SegmentPlanes out;
    for (std::size_t i = 0; i < header_.frames.size(); ++i)
      out.frames[planeOf(i, step)].push_back({header_.segments[i], static_cast<std::int64_t>(i)});
    for (auto& [plane, frames] : out.frames)
      std::sort(frames.begin(), frames.end(), [](const SegmentFrame& a, const SegmentFrame& b) {
        return std::pair(a.segment, a.frame) < std::pair(b.segment, b.frame);
      });
    out.geometry.dims = {header_.pixels.columns, header_.pixels.rows, out.frames.rbegin()->first + 1};
    out.geometry.world_from_index =
        directionsAffine({x * first_.spacing->x, y * first_.spacing->y, normal_ * step}, origin_);
    out.geometry.frame = PatientFrame::kLps;
    out.geometry.unit = "mm";
    requireInvertible(out.geometry.world_from_index, header_.path.string());
    return out;
  }

 private:
  [[noreturn]] void fail(std::size_t frame, const std::string& what) const {
    throw Error(ErrorCode::kFormat, header_.path, fmt::format("frame {}", frame + 1), what);
  }
  double along(const DicomFrame& frame) const { return glm::dot(*frame.position, normal_); }

  void requirePlaced() const {
    for (std::size_t i = 0; i < header_.frames.size(); ++i) {
      const DicomFrame& frame = header_.frames[i];
      if (!frame.position || !frame.along_row || !frame.spacing)
        fail(i, "has no position, orientation or spacing of pixels, so that its segment has no place");
      if (const std::string fault = orientationFault(frame); !fault.empty()) fail(i, fault);
      if (isTurned(frame, first_)) fail(i, "is turned against frame 1; planes of one volume are parallel");
      if (isResized(frame, first_)) fail(i, "has pixels of another size than frame 1; planes of one volume are alike");
    }
  }

  // Returns the smallest gap between frames of one segment; a pixel if no segment has two planes. Frames of one segment
  // lie in different planes, whereas frames of several segments in one plane may differ by noise.
  double gapWithinSegments() const {
    std::map<int, std::vector<double>> heights;
    for (std::size_t i = 0; i < header_.frames.size(); ++i)
      heights[header_.segments[i]].push_back(along(header_.frames[i]));
    double out = 0;
    for (auto& [segment, own] : heights) {
      std::sort(own.begin(), own.end());
      for (std::size_t i = 1; i < own.size(); ++i)
        if (const double gap = own[i] - own[i - 1]; gap > kSamePlane * first_.spacing->x && (out == 0 || gap < out))
          out = gap;
    }
    return out > 0 ? out : first_.spacing->x;
  }

  // Returns the gaps between neighbouring planes, from the lowest plane up. The lowest frame of a plane is its height.
  std::vector<double> gaps() const {
    std::vector<double> heights;
    for (const DicomFrame& frame : header_.frames) heights.push_back(along(frame));
    std::sort(heights.begin(), heights.end());
    // A thickness may be far from the distance of planes.
    const double distance = first_.between > 0 ? first_.between : gapWithinSegments();
    const double noise = std::max(kSamePlane * first_.spacing->x, kPlaneTolerance * distance);
    std::vector<double> out;
    double plane = heights.front();
    for (const double height : heights) {
      if (height - plane <= noise) continue;
      out.push_back(height - plane);
      plane = height;
    }
    return out;
  }

  // The stated distance of planes, else the smallest gap: the thickness of overlapping or separate slices is another
  // length. Both may be rounded: if each gap is a multiple of that step, but the sum of gaps is no multiple, the step
  // is the sum divided by the number of planes.
  double spacing() const {
    const std::vector<double> all = gaps();
    if (all.empty()) return first_.distance() > 0 ? first_.distance() : first_.spacing->x;
    const double step = first_.between > 0 ? first_.between : *std::min_element(all.begin(), all.end());
    const auto isMultiple = [&](double gap) {
      return std::abs(gap - std::round(gap / step) * step) <= kGapTolerance * step;
    };
    if (!std::all_of(all.begin(), all.end(), isMultiple)) return step;
    double whole = 0, planes = 0;
    for (const double gap : all) whole += gap, planes += std::round(gap / step);
    const bool adds_up = planes == 0 || std::abs(whole - planes * step) <= kPlaneTolerance * step;
    return adds_up ? step : whole / planes;
  }

  std::int64_t planeOf(std::size_t i, double step) const {
    const glm::dvec3 from_origin = *header_.frames[i].position - origin_;
    const double height = glm::dot(from_origin, normal_), plane = std::round(height / step);
    if (glm::length(from_origin - normal_ * height) > kPlaneTolerance * (step + first_.spacing->x))
      fail(i, "lies beside the line of the others; planes of one volume lie above each other");
    if (std::abs(height - plane * step) > kPlaneTolerance * step)
      fail(i, fmt::format("lies {:.6g} mm above the lowest frame, which is no multiple of the {:.6g} mm between planes",
                          height, step));
    if (plane >= std::numeric_limits<std::int32_t>::max()) fail(i, "lies too far from the others");
    return static_cast<std::int64_t>(plane);
  }

  const DicomHeader& header_;
  const DicomFrame& first_;
  glm::dvec3 normal_{}, origin_{};
};

class SegmentationSource : public VolumeSource {
 public:
  SegmentationSource(SourceInfo info, const DicomHeader& header, SegmentPlanes planes)
      : info_(std::move(info)),
        file_(header.path),
        pixels_(header.pixels),
        planes_(std::move(planes.frames)),
        pixel_bits_(header.largest_fraction ? 8 : 1),
        frame_bits_(static_cast<std::uint64_t>(header.pixels.columns * header.pixels.rows) * pixel_bits_) {}

  /// Inflates the bits of a deflated object. throws: Error kBudget, kFormat, kIo.
  void inflate(std::uint64_t memory_bytes);

  const SourceInfo& info() const override { return info_; }
  ReadOrder order() const override { return ReadOrder::kAnyBox; }
  void read(const VoxelBox& box, std::span<std::byte> out) override;
  std::uint64_t heldBytes() const override { return inflated_.size(); }
  std::uint64_t decodeBytes() const override { return frame_bits_ / 8 + 2; }

 private:
  std::vector<std::byte> bytesAt(std::uint64_t first, std::uint64_t count) const;
  void copyFrame(const SegmentFrame& frame, const VoxelBox& box, std::byte* slice) const;
  template <class T>
  void drawFrame(const SegmentFrame& frame, const VoxelBox& box, std::byte* slice) const;

  SourceInfo info_;
  File file_;
  DicomPixels pixels_;
  std::map<std::int64_t, std::vector<SegmentFrame>> planes_;
  std::uint64_t pixel_bits_, frame_bits_;
  std::vector<std::byte> inflated_;
};

void SegmentationSource::inflate(std::uint64_t memory_bytes) {
  const std::uint64_t bytes = (frame_bits_ * static_cast<std::uint64_t>(pixels_.frames) + 7) / 8;
  if (bytes > memory_bytes)
    throw Error(ErrorCode::kBudget, file_.path(), "--memory",
                fmt::format("the deflated segments take {} in memory (allowed: {})", formatBytes(bytes),
                            formatBytes(memory_bytes)));
  inflated_.resize(static_cast<std::size_t>(bytes));
  DicomInflated elements(file_.path(), pixels_.deflated_offset_bytes);
  if (elements.readSomeAt(pixels_.offset_bytes, inflated_) < inflated_.size())
    throw Error(ErrorCode::kFormat, file_.path(), "",
                "the deflated elements end before the last segment; the file is cut short or its header is wrong");
}

std::vector<std::byte> SegmentationSource::bytesAt(std::uint64_t first, std::uint64_t count) const {
  std::vector<std::byte> out(static_cast<std::size_t>(count));
  if (inflated_.empty())
    file_.readAt(pixels_.offset_bytes + first, out);
  else
    std::memcpy(out.data(), inflated_.data() + first, out.size());
  return out;
}

// Sets the voxels of a slice of `box` whose bits are set.
template <class T>
void SegmentationSource::drawFrame(const SegmentFrame& frame, const VoxelBox& box, std::byte* slice) const {
  const auto label = static_cast<T>(frame.segment);
  const std::int64_t columns = pixels_.columns;
  const std::uint64_t first =
      static_cast<std::uint64_t>(frame.frame) * frame_bits_ + static_cast<std::uint64_t>(box.lo.y * columns);
  const std::uint64_t first_byte = first / 8, bits = static_cast<std::uint64_t>(box.extent().y * columns);
  const std::vector<std::byte> bytes = bytesAt(first_byte, (first + bits + 7) / 8 - first_byte);
  for (std::int64_t y = 0; y < box.extent().y; ++y) {
    std::uint64_t bit = first - 8 * first_byte + static_cast<std::uint64_t>(y * columns + box.lo.x);
    for (std::int64_t x = 0; x < box.extent().x; ++x, ++bit) {
      if ((bytes[bit / 8] >> (bit % 8) & std::byte{1}) == std::byte{0}) continue;
      std::memcpy(slice + static_cast<std::size_t>(y * box.extent().x + x) * sizeof(T), &label, sizeof(T));
    }
  }
}

// Copies the fractions of a slice of `box`.
void SegmentationSource::copyFrame(const SegmentFrame& frame, const VoxelBox& box, std::byte* slice) const {
  const auto row = static_cast<std::uint64_t>(box.extent().x), line = static_cast<std::uint64_t>(pixels_.columns);
  const std::uint64_t first = static_cast<std::uint64_t>(frame.frame) * (frame_bits_ / 8) +
                              static_cast<std::uint64_t>(box.lo.y) * line + static_cast<std::uint64_t>(box.lo.x);
  const auto rows = static_cast<std::uint64_t>(box.extent().y);
  const std::vector<std::byte> bytes = bytesAt(first, (rows - 1) * line + row);
  for (std::uint64_t y = 0; y < rows; ++y) std::memcpy(slice + y * row, bytes.data() + y * line, row);
}

void SegmentationSource::read(const VoxelBox& box, std::span<std::byte> out) {
  assert(intersection(box, boxOf(info_.geometry.dims)) == box);
  if (box.empty()) return;
  std::fill(out.begin(), out.end(), std::byte{0});
  const std::size_t slice = static_cast<std::size_t>(box.extent().x * box.extent().y) * sizeOf(info_.type);
  for (auto plane = planes_.lower_bound(box.lo.z); plane != planes_.end() && plane->first < box.hi.z; ++plane) {
    std::byte* const to = out.data() + static_cast<std::size_t>(plane->first - box.lo.z) * slice;
    for (const SegmentFrame& frame : plane->second) {
      if (pixel_bits_ == 8)
        copyFrame(frame, box, to);
      else if (info_.type == VoxelType::u8)
        drawFrame<std::uint8_t>(frame, box, to);
      else
        drawFrame<std::uint16_t>(frame, box, to);
    }
  }
}

// Leaves the frames of one segment, because fractions of several segments are several volumes. Names the segment in
// `info`.
void chooseFractions(const DicomHeader& header, const SourceOptions& options, SegmentPlanes& planes, SourceInfo& info) {
  const std::set<int> numbers(header.segments.begin(), header.segments.end());
  std::vector<std::string> names;
  for (const int number : numbers) names.push_back(fmt::format("segment {}", number));
  const std::int64_t chosen = chosenChannel(options, names, header.path);
  const int segment = *std::next(numbers.begin(), chosen);
  for (auto& [plane, frames] : planes.frames) {
    std::erase_if(frames, [&](const SegmentFrame& frame) { return frame.segment != segment; });
    if (frames.size() > 1)
      throw Error(
          ErrorCode::kFormat, header.path, fmt::format("frame {}", frames[1].frame + 1),
          fmt::format("lies where frame {} lies, and both hold fractions of segment {}", frames[0].frame + 1, segment));
  }
  info.format += fmt::format(", segment {}", segment);
  info.notes.push_back(
      fmt::format("values are fractions of segment {}, from 0 to {}", segment, *header.largest_fraction));
}

}  // namespace

Extent3 segmentationDims(const DicomHeader& header) { return PlaneFinder(header).run().geometry.dims; }

std::unique_ptr<VolumeSource> openSegmentation(SourceInfo info, const DicomHeader& header,
                                               const SourceOptions& options) {
  if (options.spacing) refuseSpacing(header.path);
  SegmentPlanes planes = PlaneFinder(header).run();
  info.geometry = planes.geometry;
  const bool wide = *std::max_element(header.segments.begin(), header.segments.end()) > 255;
  info.type = wide && !header.largest_fraction ? VoxelType::u16 : VoxelType::u8;
  checkedBytes(info.geometry.dims, info.type, header.path);
  if (header.largest_fraction)
    chooseFractions(header, options, planes, info);
  else
    info.volume_class = VolumeClass::kLabels;
  const bool shared = std::any_of(planes.frames.begin(), planes.frames.end(),
                                  [](const auto& plane) { return plane.second.size() > 1; });
  if (shared) info.notes.push_back("where segments overlap, the one with the greatest number is taken");
  auto out = std::make_unique<SegmentationSource>(std::move(info), header, std::move(planes));
  if (header.pixels.deflated_offset_bytes > 0) out->inflate(options.memory_bytes);
  return out;
}

}  // namespace kiln
