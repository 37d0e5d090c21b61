#include "python/picture.h"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <optional>
#include <utility>

#include "base/progress.h"
#include "frame/background.h"
#include "image/file/image_file.h"
#include "image/image_rows.h"
#include "image/shown_row.h"
#include "job/job_facts.h"
#include "job/stereo.h"
#include "python/job_words.h"
#include "sequence/frame_annotations.h"
#include "store/store_reader.h"

namespace kiln::python {
namespace {

Finish finishOf(const DrawnFrame& drawn) { return kiln::finishOf(drawn.scene.picture, drawn.scene.transfer_function); }

PixelRect pixelsOf(const PictureOptions& picture) { return drawnPixels(picture.size, picture.crop); }

// Floats of a picture, which they keep.
struct Floats {
  std::shared_ptr<const Picture> picture;
  const float* values;
  std::vector<py::ssize_t> shape;

  py::buffer_info buffer() const {
    std::vector<py::ssize_t> strides(shape.size(), sizeof(float));
    for (std::size_t i = shape.size() - 1; i-- > 0;) strides[i] = strides[i + 1] * shape[i + 1];
    return {const_cast<float*>(values),
            sizeof(float),
            py::format_descriptor<float>::format(),
            static_cast<py::ssize_t>(shape.size()),
            shape,
            strides,
            true};
  }
};

}  // namespace

Picture::Picture(RenderJob job, int frame, DrawnFrame drawn, std::shared_ptr<const BrickedVolume> volume)
    : job_(std::move(job)), frame_(frame), drawn_(std::move(drawn)), volume_(std::move(volume)) {
  const Finish finish = finishOf(drawn_);
  if (finish.none()) return;
  for (const DrawnView& view : drawn_.views) {
    light_.push_back(view.image);
    finishPicture(light_.back(), pixelsOf(drawn_.scene.picture).y0, finish, Medium::kLight);
  }
}

std::vector<std::uint8_t> Picture::srgbBytes(std::size_t view) const {
  const Image& image = drawn_.views[view].image;
  const PixelRect drawn = pixelsOf(drawn_.scene.picture);
  const Annotators annotators = annotatorsOf(job_, drawn_);
  ShownView shown(image, drawn_.scene, annotators[view].get(), depthOf(image));
  const auto row_bytes = static_cast<std::size_t>(image.width) * 4;
  std::vector<std::uint8_t> out(row_bytes * static_cast<std::size_t>(image.height));
  for (int y = 0; y < image.height; ++y) {
    const ImageRows::Band band = shown.rows().bandAt(y);
    encodeShownRow(*band.image, y - band.first_row, y, {drawn.x0, drawn.y0, 1}, 8,
                   out.data() + static_cast<std::size_t>(y) * row_bytes);
  }
  return out;
}

RenderJob Picture::jobOf(std::size_t view) const {
  RenderJob out = job_;
  if (view > 0) out.picture.stereo->eye = StereoEye::kRight;
  return out;
}

DrawnFrame Picture::rightEye() const {
  DrawnFrame out = drawn_;
  out.scene.picture.stereo->eye = StereoEye::kRight;
  out.views.erase(out.views.begin());
  return out;
}

std::vector<std::byte> Picture::png(std::size_t view) const {
  RenderJob job = jobOf(view);
  job.picture.aovs = {};  // no PNG holds planes
  if (view > 0) return pngOf(job, rightEye(), *volume_, Progress());
  return pngOf(job, drawn_, *volume_, Progress());
}

void Picture::save(std::size_t view, const std::filesystem::path& path, const GivenFlags& flags) const {
  if (path.empty()) throw Error(ErrorCode::kUsage, "save: the name is empty; name the picture to write");
  if (isVideo(path))
    throw Error(ErrorCode::kUsage, path, "",
                "a video needs frames (found 1); give kiln.render a job with frames, or name a picture, .exr or .png");
  if (const auto other = flags.otherThan(
          {"--exr-type", "--compression", "--owner", "--comments", "--exr-statistics", "--png-bits", "--jpeg-quality"}))
    throw Error(ErrorCode::kUsage, *other + ": is no option of a file; draw the picture with it");
  DrawnFrame drawn = view > 0 ? rightEye() : drawn_;
  RenderJob job = jobOf(view);
  if (hasEyePlace(path) && drawn.views.size() < 2)
    throw Error(ErrorCode::kUsage, path, "", "%V stands for the eyes of a pair, and no pair is drawn; leave %V out");
  flags.apply(job);
  job.output.files.clear();
  job.output.video = {};
  job.output.path = path;
  if (!isExrPath(path)) job.picture.aovs = {};
  requireOutputs(job, {frame_});
  requireOutsideStores(path);
  write(job, std::move(drawn));
}

void Picture::writeFiles() const {
  if (!filesOf(job_, frame_).empty()) write(job_, drawn_);
}

void Picture::write(const RenderJob& job, DrawnFrame drawn) const {
  requirePlaces(job, frame_);
  writeFrame(job, frame_, drawn, *volume_, job.speed.memory_bytes);
}

std::string Picture::jobText() const { return frameText(job_, {}, drawn_.scene); }

void bindPicture(py::module_& module) {
  using Shared = const std::shared_ptr<Picture>&;
  py::class_<Floats>(module, "Floats", py::buffer_protocol()).def_buffer(&Floats::buffer);
  py::class_<Picture, std::shared_ptr<Picture>>(module, "Picture")
      .def_property_readonly("views", &Picture::views)
      .def_property_readonly("frame", &Picture::frame)
      .def_property_readonly("job", &Picture::jobText)
      .def("size",
           [](const Picture& self, std::size_t view) {
             const Image& image = self.light(view);
             return py::make_tuple(image.height, image.width);
           })
      .def("colors",
           [](Shared self, std::size_t view) {
             const Image& image = self->light(view);
             return Floats{self, image.rgba.data(), {image.height, image.width, 4}};
           })
      .def("planes",
           [](Shared self, std::size_t view) {
             const Image& image = self->light(view);
             py::dict out;
             for (const Plane& plane : image.planes)
               out[py::str(plane.name)] = Floats{self, plane.values.data(), {image.height, image.width}};
             return out;
           })
      .def("srgb",
           [](Shared self, std::size_t view) {
             const auto bytes = resultForCall(py::none(), [&](Progress&) { return self->srgbBytes(view); });
             return py::bytearray(reinterpret_cast<const char*>(bytes.data()), bytes.size());
           })
      .def("png",
           [](Shared self, std::size_t view) {
             const auto bytes = resultForCall(py::none(), [&](Progress&) { return self->png(view); });
             return py::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
           })
      .def("save", [](Shared self, std::size_t view, const std::filesystem::path& path, const Texts& texts) {
        const GivenFlags flags = givenFlags(texts);
        runForCall(py::none(), [&](Progress&) { self->save(view, path, flags); });
      });
}

}  // namespace kiln::python
