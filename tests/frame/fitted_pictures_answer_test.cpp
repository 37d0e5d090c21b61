// A picture that fits what is visible cuts nothing that a person sees. Known: a fog that fades by itself is dark at the
// border of the picture and visible near it; the cut face of a section ends inside the picture.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/shown_box.h"
#include "scene/camera/framing.h"
#include "store/store_reader.h"
#include "support/reference/drawing.h"
#include "support/volumes/procedural.h"
#include "support/volumes/test_store.h"

namespace kiln::test {
namespace {

// Greatest alpha of the pixels that are at most `inset` pixels from the border.
float mostAtBorder(const Image& image, int inset) {
  float out = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (std::min({x, y, image.width - 1 - x, image.height - 1 - y}) <= inset)
        out = std::max(out, image.pixel(x, y)[3]);
    }
  }
  return out;
}

Image fitted(const StoreReader& store, FrameRequest request, Side side) {
  const ShownBox shown = shownBox(store, std::vector{request.transfer_function}, request.clipping);
  Framing framing;
  framing.side = side;
  framing.projection = Projection::kOrthographic;
  const ImageSize size{120, 120};
  request.view =
      resolve(frameVolume({partOf(store.manifest().geometry(), shown.box), Fit::kVisible}, framing, size), size);
  return draw(store, request);
}

TEST(FittedPictures, Fog_fadesInsideThePicture) {
  const DenseVolume volume = fill({{96, 80, 90}}, [](auto x, auto y, auto z) {
    const double dx = x - 48.0, dy = y - 40.0, dz = z - 45.0;
    return std::floor(255 * std::exp(-(dx * dx + 1.5 * dy * dy + dz * dz) / (2 * 13 * 13)));
  });
  for (const std::int64_t brick : {32, 128}) {
    const StoreReader store(makeStore(volume, "fog" + std::to_string(brick), brick));
    FrameRequest request = answerRequest(volume.geometry, {0, -1, 0}, Projection::kOrthographic, 120);
    request.transfer_function = {1, {{0, glm::dvec3(1), 0}, {255, glm::dvec3(1), 0.02}}};
    for (const Side side : {Side::kFront, Side::kLeft, Side::kTop}) {
      const Image image = fitted(store, request, side);
      EXPECT_LT(mostAtBorder(image, 0), 0.004f) << brick;
      EXPECT_GT(mostAtBorder(image, 60), 0.3f) << brick;
      // The picture is not much larger than the fog: near its border a ray has 1 of 255 steps of light.
      if (brick == 128) {
        EXPECT_GT(mostAtBorder(image, 12), 0.003f);
      }
    }
  }
}

TEST(FittedPictures, FacesOfSections_endInsideThePicture) {
  const DenseVolume volume = fill({{60, 50, 40}}, [](auto x, auto y, auto z) {
    return x > 20 && x < 30 && y > 20 && y < 45 && z > 15 && z < 25 ? 255.0 : 10.0;
  });
  const StoreReader store(makeStore(volume, "cut", 128));
  FrameRequest request = answerRequest(volume.geometry, {0, -1, 0}, Projection::kOrthographic, 120);
  request.transfer_function = {1, {{100, glm::dvec3(1), 0}, {200, glm::dvec3(1), 1}}};
  request.clipping.planes = {{{0, 1, 0}, -30}};
  EXPECT_EQ(mostAtBorder(fitted(store, request, Side::kFront), 2), 0);
  request.clipping.section = Section{"gray", glm::dvec2(128, 255), 1};
  const Image face = fitted(store, request, Side::kFront);
  EXPECT_EQ(mostAtBorder(face, 2), 0);
  // 60 of the 63.6 voxels of the picture's width are the face.
  EXPECT_EQ(mostAtBorder(face, 5), 1);
}

}  // namespace
}  // namespace kiln::test
