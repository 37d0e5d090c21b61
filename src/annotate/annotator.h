// Lays annotations over a picture, or writes annotations into planes.
//
// Invariant: a pixel of the annotations depends only on its place in the whole picture and on its depth. So crops,
// tiles and bands of rows equal the whole picture.
#pragma once

#include <cstdint>
#include <vector>

#include "annotate/coverage.h"
#include "annotate/drawing.h"
#include "image/image.h"
#include "image/image_rows.h"

namespace kiln {

class Annotator {
 public:
  /// throws: Error kUnsupported for letters without a font.
  explicit Annotator(const AnnotatedPicture& picture);
  /// Draws shapes in their order over these pixels of the whole picture.
  Annotator(std::vector<Shape> shapes, const PixelRect& pixels);

  /// Composites the annotations over an image's colours. `first_row`: of the image, in the whole picture. `column`: of
  /// the first drawn column, in the image. `depth`: the plane "Z" of the image's rows; may be null.
  void over(Image& image, int column, int first_row, const float* depth) const;
  /// Appends the planes annotation.R, .G, .B and .A, in linear light, premultiplied.
  void addPlanes(Image& image, int first_row, const float* depth) const;

  const PixelRect& pixels() const { return pixels_; }

 private:
  struct Layer {
    Shape shape;
    Coverage coverage;
  };
  // Draws a row of the drawn columns. shape: 4 floats a pixel.
  void drawRow(int row, const float* depth, std::vector<float>& rgba) const;

  const PixelRect pixels_;
  std::vector<Layer> layers_;
};

/// Begins the names of the planes of annotations.
inline constexpr const char* kAnnotationPlanes = "annotation.";

/// Returns the rows of the plane "Z" of a picture; null if the picture has none.
const float* depthOf(const Image& image);

/// Rows of a picture with annotations laid over.
class AnnotatedRows : public ImageRows {
 public:
  /// requires: all arguments outlive the object. `depth`: of all rows; may be null.
  AnnotatedRows(ImageRows& rows, const Annotator& annotator, const float* depth);
  Band bandAt(int row) override;
  /// Memory beside the rows. unit: bytes.
  static std::uint64_t bytesFor(int width);

 private:
  ImageRows& rows_;
  const Annotator& annotator_;
  const float* const depth_;
  Image band_;
  int band_row_ = 0;
};

}  // namespace kiln
