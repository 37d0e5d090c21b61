#include "python/volume.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <utility>

#include "base/duration_text.h"
#include "base/memory/memory.h"
#include "base/shell_text.h"
#include "base/thread/parallel.h"
#include "convert/foreign_cache.h"
#include "convert/source_volume.h"
#include "export/source/store_boxes.h"
#include "frame/empty_frame.h"
#include "job/job_facts.h"
#include "scene/transfer/label_styles.h"
#include "store/store_reader.h"

namespace kiln::python {
namespace {

py::tuple zyx(const Extent3& dims) { return py::make_tuple(dims.z, dims.y, dims.x); }

py::list rowsOf(const glm::dmat4& affine) {
  py::list out;
  for (int row = 0; row < 4; ++row)
    out.append(py::make_tuple(affine[0][row], affine[1][row], affine[2][row], affine[3][row]));
  return out;
}

py::object labelsOfVolume(const Manifest& manifest) {
  if (manifest.volume_class != VolumeClass::kLabels) return py::none();
  const auto counts = labelsOf(manifest);
  if (!counts) return py::none();
  py::dict out;
  for (const LabelCount& label : *counts) out[py::int_(static_cast<std::int64_t>(label.label))] = label.voxels;
  return out;
}

py::dict factsOf(const BrickedVolume& volume) {
  const Manifest& manifest = volume.manifest();
  const VolumeGeometry& geometry = manifest.geometry();
  const glm::dvec3 spacing = geometry.spacing();
  py::list levels;
  for (const LevelInfo& level : manifest.levels) levels.append(zyx(level.geometry.dims));
  py::dict out;
  out["path"] = textOfPath(volume.path());
  out["shape"] = zyx(geometry.dims);
  out["type"] = nameOf(manifest.type);
  out["affine"] = rowsOf(geometry.world_from_index);
  out["spacing"] = py::make_tuple(spacing.z, spacing.y, spacing.x);
  out["unit"] = geometry.unit;
  out["frame"] = wordOf(geometry.frame);
  out["levels"] = py::tuple(levels);
  out["range"] = manifest.range.empty() ? py::object(py::none()) : py::make_tuple(manifest.range.lo, manifest.range.hi);
  out["nan_count"] = manifest.nan_count;
  out["histogram"] = py::make_tuple(manifest.histogram.lo, manifest.histogram.hi, manifest.histogram.counts);
  out["labels"] = labelsOfVolume(manifest);
  return out;
}

using Box = std::array<std::array<std::int64_t, 2>, 3>;  // z, y, x

VoxelBox boxIn(const BrickedVolume& volume, int level, const Box& box) {
  volume.requireLevel(level);
  const VoxelBox out{{box[2][0], box[1][0], box[0][0]}, {box[2][1], box[1][1], box[0][1]}};
  const Extent3& dims = volume.level(level).geometry.dims;
  if (out.lo.x < 0 || out.lo.y < 0 || out.lo.z < 0 || out.hi.x > dims.x || out.hi.y > dims.y || out.hi.z > dims.z ||
      out.lo.x > out.hi.x || out.lo.y > out.hi.y || out.lo.z > out.hi.z)
    throw Error(ErrorCode::kUsage, volume.path(), "box",
                fmt::format("is not in level {} of {} x {} x {} voxels along z, y, x", level, dims.z, dims.y, dims.x));
  return out;
}

py::bytearray voxelsOf(const Volume& volume, int level, const Box& box, const py::object& on_progress) {
  const std::shared_ptr<const BrickedVolume>& bricks = volume.bricks();
  const VoxelBox voxels = boxIn(*bricks, level, box);
  const Extent3 n = voxels.extent();
  py::bytearray out(nullptr, static_cast<py::size_t>(n.x * n.y * n.z) * sizeOf(bricks->manifest().type));
  const std::span<std::byte> bytes(reinterpret_cast<std::byte*>(PyByteArray_AS_STRING(out.ptr())),
                                   static_cast<std::size_t>(PyByteArray_GET_SIZE(out.ptr())));
  if (!bytes.empty())
    runForCall(on_progress, [&](Progress& progress) { readBox(*bricks, level, voxels, progress, bytes); });
  return out;
}

}  // namespace

std::vector<const BrickedVolume*> pointersTo(const std::vector<std::shared_ptr<const BrickedVolume>>& volumes) {
  std::vector<const BrickedVolume*> out;
  for (const auto& volume : volumes) out.push_back(volume.get());
  return out;
}

namespace {

// Whether the jobs' volumes have equal companions, which a session opens once.
bool haveEqualCompanions(const RenderJob& a, const RenderJob& b) {
  return a.companions == b.companions &&
         std::equal(a.volumes.begin(), a.volumes.end(), b.volumes.begin(), b.volumes.end(),
                    [](const VolumeOptions& x, const VolumeOptions& y) { return x.companions == y.companions; });
}

}  // namespace

struct Drawing::Session {
  Session(const RenderJob& for_job, const Volumes& of_job)
      : job(for_job), volumes(of_job), painter(job, OpenedVolumes(job, pointersTo(volumes)), relay) {}
  bool serves(const RenderJob& other, const Volumes& of_other) const {
    return of_other == volumes && other.speed.memory_bytes == job.speed.memory_bytes &&
           other.picture.skip_damaged == job.picture.skip_damaged && haveEqualCompanions(other, job);
  }

  const RenderJob job;
  const Volumes volumes;
  Relay relay;
  ViewPainter painter;
};

std::shared_ptr<Picture> Drawing::draw(const RenderJob& job, const Volumes& volumes, Progress& progress) {
  // Calls have no order: each draws to its end.
  constexpr std::uint64_t kAnyCall = 1;
  const DrawingTurns::Turn turn(turns_, kAnyCall, [&] { return progress.cancelled(); });
  if (!turn.given()) throw Error(ErrorCode::kCancelled, "interrupted while another picture of the volume was drawn");
  const ThreadLimit threads(job.speed.threads);
  if (!session_ || !session_->serves(job, volumes)) {
    session_.reset();  // frees memory before the next cache takes it
    session_ = std::make_shared<Session>(job, volumes);
  }
  const Relay::Scope scope(session_->relay, progress);
  ViewPainter& painter = session_->painter;
  const std::unique_ptr<ViewedJob> ready = painter.prepare(job, progress);
  for (const Doubt& doubt : painter.doubts(*ready)) progress.warn(doubt.sentence);
  DrawnFrame drawn = painter.exact(*ready, progress);
  noteDamage(drawn.statistics, progress);
  warnOfDoubtfulFrames({drawn.statistics}, false, progress);
  return std::make_shared<Picture>(ready->job, ready->frame, std::move(drawn), volumes.front());
}

std::filesystem::path storeForCall(const std::filesystem::path& path, const SourceWords& words,
                                   const std::filesystem::path& store_directory, bool labels,
                                   std::uint64_t memory_bytes, Progress& progress) {
  ConvertOptions conversion;
  conversion.memory_bytes = memory_bytes;
  conversion.labels = labels;
  // Names the command whose stores may be made anew.
  conversion.command = "kiln render " + shellText(path.string());
  conversion.time = timeNow();
  return storeFor({path, words.resolve(), store_directory}, conversion, progress);
}

namespace {

Drawing::Volumes bricksOf(const std::vector<const Volume*>& volumes) {
  Drawing::Volumes out;
  for (const Volume* volume : volumes) out.push_back(volume->bricks());
  return out;
}

}  // namespace

AddedVolumes MoreVolumes::names() const {
  AddedVolumes out;
  for (const auto& volume : added) out.added.push_back(volume->path());
  for (const auto& volume : labels) out.labels.push_back(volume->path());
  for (const std::string& function : functions) out.functions.push_back(functionOf(function));
  return out;
}

Drawing::Volumes MoreVolumes::behind(const Volume& first) const {
  Drawing::Volumes out = {first.bricks()};
  for (const Drawing::Volumes& list : {added, labels}) out.insert(out.end(), list.begin(), list.end());
  return out;
}

void bindVolume(py::module_& module) {
  py::class_<MoreVolumes>(module, "MoreVolumes")
      .def(py::init([](const std::vector<const Volume*>& added, const std::vector<const Volume*>& labels,
                       std::vector<std::string> functions) {
        return MoreVolumes{bricksOf(added), bricksOf(labels), std::move(functions)};
      }));
  py::class_<Volume, UnlockedPointer<Volume>>(module, "Volume")
      .def_static("open_file",
                  [](const std::filesystem::path& path, const std::map<std::string, std::string>& texts,
                     const std::filesystem::path& store, bool labels, const std::string& memory,
                     const py::object& on_progress) {
                    const SourceWords words = sourceWords(texts);
                    const std::uint64_t bytes = parseBytes(memory, "memory");
                    return UnlockedPointer<Volume>(new Volume(resultForCall(on_progress, [&](Progress& progress) {
                      const std::filesystem::path made = storeForCall(path, words, store, labels, bytes, progress);
                      return std::shared_ptr<const BrickedVolume>(std::make_shared<StoreReader>(made, bytes));
                    })));
                  })
      .def_static(
          "open_array",
          [](ArraySource& source, std::int64_t brick_size, const std::string& memory, const py::object& on_progress) {
            ArrayOptions options;
            options.brick_size = brick_size;
            options.labels = source.labels();
            options.memory_bytes = parseBytes(memory, "memory");
            std::unique_ptr<VolumeSource> taken = source.take();
            std::shared_ptr<const BrickedVolume> out;
            source.run(on_progress, [&](Progress& progress) {
              out = std::make_shared<SourceVolume>(std::move(taken), options, progress);
            });
            return UnlockedPointer<Volume>(new Volume(std::move(out)));
          })
      .def("facts", [](const Volume& volume) { return factsOf(*volume.bricks()); })
      .def("read", &voxelsOf)
      .def("frames",
           [](const Volume& volume, const JobWords& words) { return framesOf(jobOf(volume.bricks()->path(), words)); })
      .def("draw", [](const Volume& volume, const JobWords& words, const MoreVolumes& more, std::optional<int> frame,
                      const py::object& on_progress) {
        RenderJob job = jobOf(volume.bricks()->path(), words, more.names());
        if (frame) job.frames = {*frame};
        const Drawing::Volumes volumes = more.behind(volume);
        return resultForCall(on_progress,
                             [&](Progress& progress) { return volume.drawing().draw(job, volumes, progress); });
      });
}

}  // namespace kiln::python
