#include "support/reference/reference_cache.h"

#include <fmt/format.h>

#include "base/hash.h"
#include "image/file/image_file.h"

namespace kiln::test {
namespace {

/// Raise the version whenever the reference renderer's pictures change.
constexpr int kReferenceVersion = 2;

// Hexadecimal floats, so that different values have different texts.
std::string textOf(const glm::dmat4& m) {
  std::string out;
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) out += fmt::format("{:a} ", m[column][row]);
  }
  return out;
}

std::string textOf(const View& view) {
  return fmt::format("view {} {}x{} {}{:a} {:a} {:a}\n", static_cast<int>(view.projection), view.size.width,
                     view.size.height, textOf(view.view_from_world), view.focal_px, view.centre_px.x, view.centre_px.y);
}

std::string textOf(const TransferFunction& transfer_function) {
  std::string out = fmt::format("transfer function {:a}", transfer_function.unit);
  for (const TransferPoint& p : transfer_function.points)
    out += fmt::format(" {:a} {:a} {:a} {:a} {:a},", p.value, p.color.r, p.color.g, p.color.b, p.opacity);
  return out + "\n";
}

std::string textOf(const Shading& s) {
  std::string out = fmt::format("shading {} {:a} {:a} {:a} {:a}\n", s.phong, s.ambient, s.diffuse, s.specular, s.power);
  // Default lights add no text, so that older pictures stay valid.
  if (s.lights == Shading().lights) return out;
  for (const Light& light : s.lights) {
    out += fmt::format("light {} {:a} {:a} {:a} {:a} {:a} {:a} {:a}\n", static_cast<int>(light.kind), light.place.x,
                       light.place.y, light.place.z, light.color.r, light.color.g, light.color.b, light.intensity);
  }
  return out;
}

std::string textOf(const ReferenceSettings& s) {
  std::string out = fmt::format("settings {} {:a} {:a}\n", s.rays_per_axis, s.step_voxels, s.opacity_threshold);
  // Linear interpolation adds no text, so that older pictures stay valid.
  if (s.interpolation != Interpolation::kLinear)
    out += fmt::format("interpolation {}\n", static_cast<int>(s.interpolation));
  return out;
}

}  // namespace

ReferencePictures::ReferencePictures(const DenseVolume& volume, std::optional<std::filesystem::path> folder)
    : volume_(volume), folder_(std::move(folder)) {
  if (!folder_) return;
  const VolumeGeometry& g = volume.geometry;
  volume_key_ =
      fmt::format("reference {}\nvolume {} {}x{}x{} {}{}\n", kReferenceVersion, static_cast<int>(volume.type), g.dims.x,
                  g.dims.y, g.dims.z, textOf(g.world_from_index), toHex(hashOf(std::span(volume.voxels))));
}

Image ReferencePictures::draw(const View& view, const TransferFunction& transfer_function, const Shading& shading,
                              const ReferenceSettings& settings) const {
  const auto make = [&] { return referenceImage(volume_, view, transfer_function, shading, {0, 0, 0, 0}, settings); };
  // Keys do not include the clipping, so clipped pictures are not stored.
  if (!folder_ || settings.clipping != Clipping()) return make();
  const std::string key = volume_key_ + textOf(view) + textOf(transfer_function) + textOf(shading) + textOf(settings);
  const std::filesystem::path file = *folder_ / (toHex(hashOf(key)) + ".exr");
  if (std::filesystem::exists(file)) return readImage(file);
  const Image image = make();
  std::filesystem::create_directories(*folder_);
  writeImage(image, {}, {.exr_float = true}, file);
  return image;
}

}  // namespace kiln::test
