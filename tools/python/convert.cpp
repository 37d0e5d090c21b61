// Conversions of files and arrays to stores.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <utility>

#include "base/duration_text.h"
#include "base/memory/memory.h"
#include "base/thread/parallel.h"
#include "convert/stream/half_source.h"
#include "ingest/open_source.h"
#include "python/modules.h"
#include "python/volume.h"

namespace kiln::python {
namespace {

// Options of a conversion beside those of its source, as keywords of Python.
struct ConvertWords {
  std::string memory, command;
  std::int64_t brick_size = kDefaultBrickSize;
  bool overwrite = false, resume = false, half = false, labels = false;
  int levels = 0;  // 0: all
  unsigned threads = 0;

  ConvertOptions resolve() const {
    ConvertOptions out;
    out.brick_size = brick_size;
    out.memory_bytes = parseBytes(memory, "memory");
    out.overwrite = overwrite;
    out.resume = resume;
    out.half = half;
    out.labels = labels;
    if (levels > 0) out.most_levels = levels;
    out.command = command;
    out.time = timeNow();
    return out;
  }
};

ConvertReport convertSource(std::unique_ptr<VolumeSource> source, const std::filesystem::path& out,
                            const ConvertWords& words, Progress& progress) {
  const ThreadLimit threads(words.threads);
  const ConvertOptions options = words.resolve();
  const HalfSource* rounded = nullptr;
  if (words.half) {
    auto half = std::make_unique<HalfSource>(std::move(source));
    rounded = half.get();
    source = std::move(half);
  }
  ConvertReport report = convert(*source, out, options, progress);
  if (rounded != nullptr) {
    if (const std::string lost = rounded->loss().warning(); !lost.empty()) progress.warn(out.string() + ": " + lost);
  }
  return report;
}

py::dict dictOf(const ConvertReport& report) {
  py::dict out;
  out["voxels"] = report.voxels;
  out["bricks"] = report.bricks;
  out["stored_bricks"] = report.stored_bricks;
  out["stored_bytes"] = report.stored_bytes;
  out["nan_count"] = report.nan_count;
  out["buffer_bytes"] = report.buffer_bytes;
  out["decodings"] = report.decodings;
  out["seconds"] = report.seconds;
  return out;
}

}  // namespace

void bindConvert(py::module_& module) {
  py::class_<ConvertWords>(module, "ConvertWords")
      .def(py::init<>())
      .def_readwrite("memory", &ConvertWords::memory)
      .def_readwrite("command", &ConvertWords::command)
      .def_readwrite("brick_size", &ConvertWords::brick_size)
      .def_readwrite("overwrite", &ConvertWords::overwrite)
      .def_readwrite("resume", &ConvertWords::resume)
      .def_readwrite("half", &ConvertWords::half)
      .def_readwrite("labels", &ConvertWords::labels)
      .def_readwrite("levels", &ConvertWords::levels)
      .def_readwrite("threads", &ConvertWords::threads);
  module.def("convert_file",
             [](const std::filesystem::path& path, const std::map<std::string, std::string>& texts,
                const std::filesystem::path& out, const ConvertWords& words, const py::object& on_progress) {
               const SourceWords source_words = sourceWords(texts);
               return dictOf(resultForCall(on_progress, [&](Progress& progress) {
                 SourceOptions options = source_words.resolve();
                 options.memory_bytes = words.resolve().memory_bytes;
                 return convertSource(openSource(path, options), out, words, progress);
               }));
             });
  module.def("convert_array", [](ArraySource& source, const std::filesystem::path& out, const ConvertWords& words,
                                 const py::object& on_progress) {
    if (words.resume && !source.hasState())
      throw Error(ErrorCode::kUsage,
                  "resume: an array without a file has no state to compare; give identity, a text that is another for "
                  "other voxels");
    std::unique_ptr<VolumeSource> taken = source.take();
    ConvertReport report;
    source.run(on_progress,
               [&](Progress& progress) { report = convertSource(std::move(taken), out, words, progress); });
    return dictOf(report);
  });
}

}  // namespace kiln::python
