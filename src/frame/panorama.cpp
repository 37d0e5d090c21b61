#include "frame/panorama.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "base/thread/parallel.h"
#include "frame/background.h"
#include "frame/light/illuminate.h"
#include "frame/light/shadow_views.h"
#include "frame/pass/aov_planes.h"
#include "frame/pass/frame_drawing.h"

namespace kiln {
namespace {

// Directions along a pixel's edge. Resolution of a face's middle, the coarsest place, relative to the panorama's.
constexpr int kDirections = 2;
constexpr double kFiner = 1.5;
// Width of the blend between faces, as a difference of the cosines of the angles to their middles: some 3 degrees to
// either side. Slabs at different angles give slightly different values; a slow transition hides the difference.
constexpr double kFade = 0.05;
// Cosine at which the weight of a face becomes 0: a corner is 37.4 degrees from the middle and fades over 3.1.
constexpr double kWidest = 0.86;
constexpr double kLeastCosine = 0.758;  // cosine of 40.7 degrees
// Pixels beyond a place that interpolation reads.
constexpr int kBeside = 2;

// A direction in a face.
struct FacePlace {
  double weight = 0;  // all faces together have 1; 0 where the face does not show the direction
  glm::dvec2 pixel;
  double secant = 1;   // distance over depth
  bool first = false;  // no other face has a larger weight
};

class Faces {
 public:
  explicit Faces(const View& panorama) : views_(panoramaFaces(panorama)) {
    const glm::dmat3 world_from_panorama = glm::transpose(glm::dmat3(panorama.view_from_world));
    for (std::size_t i = 0; i < views_.size(); ++i) {
      from_panorama_[i] = glm::dmat3(views_[i].view_from_world) * world_from_panorama;
      ahead_[i] = glm::transpose(from_panorama_[i])[2];
    }
  }
  const std::array<View, kPanoramaFaces>& views() const { return views_; }

  FacePlace placeOf(std::size_t face, const glm::dvec3& direction) const {
    const double cosine = glm::dot(ahead_[face], direction);
    if (cosine < kLeastCosine) return {};
    double most = cosine;
    for (const glm::dvec3& ahead : ahead_) most = std::max(most, glm::dot(ahead, direction));
    if (cosine <= most - kFade) return {};
    FacePlace out;
    double all = 0;
    for (const glm::dvec3& ahead : ahead_) all += fade(glm::dot(ahead, direction) - most);
    out.weight = fade(cosine - most) / all;
    const glm::dvec3 d = from_panorama_[face] * direction;
    out.pixel = views_[face].centre_px + views_[face].focal_px / d.z * glm::dvec2(d);
    out.secant = 1 / d.z;
    out.first = cosine == most;
    return out;
  }

 private:
  static double fade(double behind) {
    const double t = std::max(1 + behind / kFade, 0.0);
    return t * t * (3 - 2 * t);
  }

  std::array<View, kPanoramaFaces> views_;
  std::array<glm::dmat3, kPanoramaFaces> from_panorama_;
  std::array<glm::dvec3, kPanoramaFaces> ahead_;  // in the panorama's axes
};

// The four weights of Catmull-Rom at `t` behind the second pixel.
std::array<float, 4> cubicWeights(float t) {
  const float t2 = t * t, t3 = t2 * t;
  return {0.5f * (2 * t2 - t - t3), 0.5f * (3 * t3 - 5 * t2 + 2), 0.5f * (4 * t2 + t - 3 * t3), 0.5f * (t3 - t2)};
}

// A partly drawn face with interpolated access.
class DrawnFace {
 public:
  DrawnFace(const Image& image, const PixelRect& rect) : image_(image), rect_(rect) {}

  std::array<float, 4> at(const glm::dvec2& pixel) const {
    const glm::dvec2 from_centre = pixel - 0.5;
    const int x = static_cast<int>(std::floor(from_centre.x)), y = static_cast<int>(std::floor(from_centre.y));
    const std::array<float, 4> across = cubicWeights(static_cast<float>(from_centre.x - x)),
                               down = cubicWeights(static_cast<float>(from_centre.y - y));
    std::array<float, 4> out{};
    for (int j = 0; j < 4; ++j) {
      const float* const row = image_.pixel(x - 1 - rect_.x0, y - 1 + j - rect_.y0);
      for (int i = 0; i < 4; ++i) {
        const float weight = down[static_cast<std::size_t>(j)] * across[static_cast<std::size_t>(i)];
        for (int c = 0; c < 4; ++c) out[static_cast<std::size_t>(c)] += weight * row[4 * i + c];
      }
    }
    return out;
  }
  std::ptrdiff_t nearest(const glm::dvec2& pixel) const {
    return (static_cast<std::ptrdiff_t>(pixel.y) - rect_.y0) * rect_.width() + static_cast<std::ptrdiff_t>(pixel.x) -
           rect_.x0;
  }
  const Image& image() const { return image_; }

 private:
  const Image& image_;
  const PixelRect rect_;
};

// Cosines and sines of the directions of a range of columns or rows.
struct Angles {
  std::vector<double> sine, cosine;

  // Starts at pixel `first`; `middle` has angle 0.
  Angles(int first, int count, double middle, double focal_px) {
    for (int i = kDirections * first; i < kDirections * (first + count); ++i) {
      const double angle = ((i + 0.5) / kDirections - middle) / focal_px;
      sine.push_back(std::sin(angle));
      cosine.push_back(std::cos(angle));
    }
  }
};

// Returns the direction of a pixel, as panoramaDirection.
glm::dvec3 directionOf(const Angles& columns, std::size_t column, const Angles& rows, std::size_t row) {
  const double level = rows.cosine[row];
  return {columns.sine[column] * level, rows.sine[row], columns.cosine[column] * level};
}

class Panorama {
 public:
  Panorama(const View& view, const PixelRect& pixels, const Aovs& aovs)
      : image(pixels.width(), pixels.height()),
        faces_(view),
        columns_(pixels.x0, pixels.width(), view.centre_px.x, view.focal_px),
        rows_(pixels.y0, pixels.height(), view.centre_px.y, view.focal_px) {
    addAovPlanes(aovs, image);
    for (Plane& plane : image.planes) {
      if (plane.name == "Z") std::fill(plane.values.begin(), plane.values.end(), kFar);
    }
    weights_.resize(aovs.any() ? image.rgba.size() / 4 : 0);
  }

  // Adds the contribution of a face. Rows run in parallel; faces come in turn, so that sums have a fixed order.
  void add(std::size_t face, const DrawnFace& drawn) {
    parallelFor(static_cast<std::size_t>(image.height), [&](std::size_t y) {
      for (int x = 0; x < image.width; ++x) {
        for (int i = 0; i < kDirections * kDirections; ++i) addDirection(face, drawn, x, static_cast<int>(y), i);
      }
    });
  }

  void finish() {
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
      // Interpolation overshoots at edges.
      for (std::size_t c = 0; c < 4; ++c) image.rgba[i + c] = std::max(image.rgba[i + c], 0.0f);
      image.rgba[i + 3] = std::min(image.rgba[i + 3], 1.0f);
    }
    for (Plane& plane : image.planes) finishPlane(plane);
    finishNormals();
  }

  Image image;

 private:
  static constexpr float kFar = std::numeric_limits<float>::infinity();

  void addDirection(std::size_t face, const DrawnFace& drawn, int x, int y, int i) {
    const auto column = static_cast<std::size_t>(kDirections * x + i % kDirections),
               row = static_cast<std::size_t>(kDirections * y + i / kDirections);
    const glm::dvec3 direction = directionOf(columns_, column, rows_, row);
    const FacePlace place = faces_.placeOf(face, direction);
    if (!(place.weight > 0)) return;
    const auto share = static_cast<float>(place.weight / (kDirections * kDirections));
    const std::array<float, 4> seen = drawn.at(place.pixel);
    float* const pixel = image.pixel(x, y);
    for (std::size_t c = 0; c < 4; ++c) pixel[c] += share * seen[c];
    if (!image.planes.empty()) addPlanes(drawn, place, share, std::ptrdiff_t{y} * image.width + x);
  }

  // Planes take the nearest pixel of a face, because interpolated depths and normals have no meaning.
  void addPlanes(const DrawnFace& drawn, const FacePlace& place, float share, std::ptrdiff_t pixel) {
    const std::ptrdiff_t from = drawn.nearest(place.pixel);
    const auto distance = static_cast<float>(place.secant);
    const float alpha = share * drawn.image().rgba[static_cast<std::size_t>(4 * from + 3)];
    for (std::size_t i = 0; i < image.planes.size(); ++i) {
      float& to = image.planes[i].values[static_cast<std::size_t>(pixel)];
      const float value = drawn.image().planes[i].values[static_cast<std::size_t>(from)];
      if (image.planes[i].name == "Z") {
        if (place.first) to = std::min(to, distance * value);
      } else if (std::isfinite(value)) {
        to += alpha * value * (image.planes[i].name == "depth.mean" ? distance : 1);
      }
    }
    weights_[static_cast<std::size_t>(pixel)] += alpha;
  }

  void finishPlane(Plane& plane) const {
    const bool is_value = plane.name == "value";
    if (!is_value && plane.name != "depth.mean") return;
    const float nothing = is_value ? std::numeric_limits<float>::quiet_NaN() : kFar;
    for (std::size_t i = 0; i < plane.values.size(); ++i)
      plane.values[i] = weights_[i] > 0 ? plane.values[i] / weights_[i] : nothing;
  }

  void finishNormals() {
    ZeroPages<float>* axes[3] = {};
    for (Plane& plane : image.planes) {
      if (plane.name.starts_with("N.")) axes[plane.name.back() - 'X'] = &plane.values;
    }
    if (axes[0] == nullptr) return;
    for (std::size_t i = 0; i < axes[0]->size(); ++i) {
      const glm::vec3 sum((*axes[0])[i], (*axes[1])[i], (*axes[2])[i]);
      const float length = glm::length(sum);
      for (int axis = 0; axis < 3; ++axis) (*axes[axis])[i] = length > 0 ? sum[axis] / length : 0;
    }
  }

  const Faces faces_;
  const Angles columns_, rows_;
  ZeroPages<float> weights_;  // sums of weights for the planes
};

}  // namespace

std::array<View, kPanoramaFaces> panoramaFaces(const View& panorama) {
  const double focal_px = kFiner * panorama.focal_px;
  const int half = static_cast<int>(std::ceil(focal_px * kWidest)) + kBeside + 1;
  std::array<View, kPanoramaFaces> out;
  for (std::size_t i = 0; i < out.size(); ++i) {
    // One face ahead, one behind, and five around either.
    const bool before = i < out.size() / 2;
    const std::size_t place = before ? i : i - out.size() / 2;
    const double from_axis = place == 0 ? 0 : std::atan(2.0);
    const double around = 2 * glm::pi<double>() * (static_cast<double>(place) / 5 + (before ? 0 : 0.1));
    const double side = before ? 1 : -1;
    const glm::dvec3 ahead(std::sin(from_axis) * std::cos(around), std::sin(from_axis) * std::sin(around),
                           side * std::cos(from_axis));
    const glm::dvec3 right = glm::normalize(glm::cross(glm::dvec3(0, 1, 0), ahead)), down = glm::cross(ahead, right);
    const glm::dmat3 from_panorama = glm::transpose(glm::dmat3(right, down, ahead));
    View& face = out[i];
    face.projection = Projection::kPerspective;
    face.size = {2 * half, 2 * half};
    face.focal_px = focal_px;
    face.centre_px = glm::dvec2(half);
    face.eye_world = panorama.eye_world;
    const glm::dmat3 axes = from_panorama * glm::dmat3(panorama.view_from_world);
    face.view_from_world = glm::dmat4(axes);
    face.view_from_world[3] = glm::dvec4(-(axes * panorama.eye_world), 1);
    face.forward_world = glm::transpose(axes)[2];
  }
  return out;
}

// A camera light has the direction of the panorama's camera, and not of a face's.
void turnLights(const View& panorama, Shading& shading) {
  for (Light& light : shading.lights) light = standing(light, panorama);
}

FrameRequest faceOf(const FrameRequest& panorama, const View& face) {
  FrameRequest out = panorama;
  out.view = face;
  turnLights(panorama.view, out.shading);
  for (VolumeRequest& volume : out.volumes) turnLights(panorama.view, volume.shading);
  out.background = {};
  out.filters_rays = false;
  return out;
}

std::array<PixelRect, kPanoramaFaces> facePixels(const View& panorama, const PixelRect& pixels) {
  const Faces faces(panorama);
  const Angles columns(pixels.x0, pixels.width(), panorama.centre_px.x, panorama.focal_px),
      rows(pixels.y0, pixels.height(), panorama.centre_px.y, panorama.focal_px);
  std::array<PixelRect, kPanoramaFaces> out;
  parallelFor(out.size(), [&](std::size_t face) {
    glm::dvec2 lo(std::numeric_limits<double>::infinity()), hi(-lo);
    for (std::size_t row = 0; row < rows.sine.size(); ++row) {
      for (std::size_t column = 0; column < columns.sine.size(); ++column) {
        const FacePlace place = faces.placeOf(face, directionOf(columns, column, rows, row));
        if (place.weight > 0) lo = glm::min(lo, place.pixel), hi = glm::max(hi, place.pixel);
      }
    }
    if (lo.x > hi.x) return;
    const glm::ivec2 first(glm::floor(lo)), last(glm::floor(hi));
    const ImageSize& size = faces.views()[face].size;
    out[face] =
        intersection(PixelRect{first.x - kBeside, first.y - kBeside, last.x + kBeside + 1, last.y + kBeside + 1},
                     {0, 0, size.width, size.height});
  });
  return out;
}

Image renderPanorama(BrickCache& cache, FrameRequest request, Progress& progress, FrameStatistics& statistics) {
  FrameStatistics of_lights;
  illuminate(cache, progress, request, of_lights);
  const PixelRect pixels = drawnPixels(request.view.size, request.crop);
  Panorama panorama(request.view, pixels, request.aovs);
  const std::array<View, kPanoramaFaces> faces = panoramaFaces(request.view);
  const std::array<PixelRect, kPanoramaFaces> drawn_pixels = facePixels(request.view, pixels);
  statistics = {};
  for (std::size_t i = 0; i < faces.size(); ++i) {
    if (drawn_pixels[i].empty()) continue;
    FrameRequest of_face = faceOf(request, faces[i]);
    of_face.crop = drawn_pixels[i];
    FrameStatistics drawn;
    const Image image = renderFrame(cache, of_face, progress, drawn);
    panorama.add(i, DrawnFace(image, *of_face.crop));
    statistics.addView(drawn);
  }
  statistics.addLights(of_lights);
  panorama.finish();
  layOverBackground(panorama.image, pixels.y0, request.view.size.height, request.background);
  return std::move(panorama.image);
}

}  // namespace kiln
