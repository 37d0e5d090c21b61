// Shapes of annotations in the order of drawing, and the sizes and colours that annotations share.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "annotate/outline.h"
#include "grid/geometry.h"
#include "image/pixel_rect.h"
#include "job/frame/frame_scene.h"
#include "job/render_job.h"
#include "scene/camera/camera.h"

namespace kiln {

/// The facts that annotations are drawn from.
struct AnnotatedPicture {
  Annotations annotations;  // placeholders are filled in
  View view;
  PixelRect pixels;         // the drawn pixels of the whole picture
  double target_depth = 1;  // depth of the camera's target. unit: world
  Background background;
  std::vector<ShownFunction> shown;  // the functions of a legend
  bool projected = false;            // the picture shows values, not light
  bool has_depth = false;            // pictures have the plane "Z"
  VolumeGeometry box;                // around all volumes
  Clipping clipping;
};

/// Shows a line at pixels where the line is in front of the picture's depth, or only where the line is behind.
struct DepthTest {
  glm::dvec2 a_px{0}, b_px{0};  // ends of the line
  double a_depth = 1, b_depth = 1;
  bool perspective = false;
  bool shows_hidden = false;
  double slack = 0;  // a line counts as behind beyond this distance. unit: world

  /// Returns whether the line is shown at a pixel of this depth.
  bool shows(const glm::dvec2& pixel, float depth) const;
};

struct Shape {
  Outline outline;
  glm::dvec3 color{0};  // linear light
  double opacity = 1;
  std::optional<DepthTest> depth{};
};

/// Sizes in pixels. All grow with the shorter side of the picture.
struct Style {
  explicit Style(const AnnotatedPicture& picture);
  Style(double font_size, const glm::dvec3& color);
  double em;      // size of the font; of annotations at least kLeastText
  double margin;  // between annotations and the border of the picture
  double line;    // width of a thin line
  double halo;    // width of the rim around letters and lines
  glm::dvec3 ink, rim;
  bool legible = true;  // false: the picture is too small for letters
};

/// Least size of the font: small letters are then five pixels high, and stay apart. unit: pixels.
inline constexpr double kLeastText = 9;
/// Distance of lines of text. unit: the font's size.
inline constexpr double kTextPitch = 1.4;

class Drawing {
 public:
  explicit Drawing(const Style& style) : style_(style) {}
  const Style& style() const { return style_; }

  /// Adds a shape in the colour of text and lines, with its rim.
  void ink(const Outline& outline, double opacity = 1);
  /// Adds a shape of its own colour, with a rim.
  void fill(const Outline& outline, const glm::dvec3& color, double opacity = 1);
  /// Adds a shape without a rim.
  void plain(Shape shape) { shapes_.push_back(std::move(shape)); }
  enum class Align { kLeft, kCentre, kRight };
  /// Writes a line of text on a base line, which is moved to a whole pixel. Returns the text's width. unit: pixels.
  double text(std::string_view utf8, const glm::dvec2& base, double size, Align align, double opacity = 1);
  /// Returns the shapes, the common rim first.
  std::vector<Shape> take() &&;

 private:
  const Style style_;
  Outline rim_;
  std::vector<Shape> shapes_;
};

/// Lightness below which a colour is dark. unit: linear light.
inline constexpr double kMiddleGrey = 0.18;

/// Lightness of a colour of linear light; 0 to 1.
double lightness(const glm::dvec3& color);

// The annotations, each in its own file.
void addScaleBar(const AnnotatedPicture& picture, Drawing& drawing);
void addLegend(const AnnotatedPicture& picture, Drawing& drawing);
void addAxes(const AnnotatedPicture& picture, Drawing& drawing);
void addText(const AnnotatedPicture& picture, Drawing& drawing);
/// Returns shapes to lie below all annotations with letters.
std::vector<Shape> outlineOfVolume(const AnnotatedPicture& picture, const Style& style);

}  // namespace kiln
