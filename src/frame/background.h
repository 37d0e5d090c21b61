// The last steps of a picture: colours as its file shows them, and the background behind them.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <memory>

#include "image/display.h"
#include "image/image.h"
#include "image/image_rows.h"
#include "job/render_job.h"

namespace kiln {

/// Lays `image`, the rows from `first_row` on of a picture of `rows` rows, over the background.
void layOverBackground(Image& image, int first_row, int rows, const Background& background);

/// Lays a background over paper of one colour. shape of `paper`: linear light.
Background overPaper(Background background, const glm::dvec3& paper);

/// Returns the medium of a picture's file.
Medium mediumOf(const std::filesystem::path& picture);

/// The steps between a drawn picture and its files, which differ between media: the display changes the volume's light
/// and not the background. A picture that is shown as it is drawn has its background already, and nothing is left.
struct Finish {
  Display display;
  Background background;
  int rows = 0;  // of the whole picture
  bool none() const { return showsAsDrawn(display); }
};
Finish finishOf(const PictureOptions& picture, const TransferFunction& transfer_function);

/// Returns the background that a frame is drawn over: none if its files lay the background.
Background drawnBackground(const PictureOptions& picture, const TransferFunction& transfer_function);

/// Finishes the rows from `first_row` of the whole picture on.
void finishPicture(Image& image, int first_row, const Finish& finish, Medium medium);

/// The rows of a picture in memory as a display shows them, some at a time; the picture stays as it is.
class ShownRows : public ImageRows {
 public:
  /// Memory beside the picture. unit: bytes.
  static std::uint64_t bytesFor(int width);
  /// `first_row`: of the whole picture. requires: the image outlives this.
  ShownRows(const Image& image, int first_row, const Finish& finish);
  Band bandAt(int row) override;

 private:
  const Image& image_;
  const int first_row_;
  const Finish finish_;
  Image band_;
  int band_row_ = 0;
};

/// Returns the rows of a picture as a display shows them. `first_row`: of the whole picture. requires: the image
/// outlives the rows.
std::unique_ptr<ImageRows> shownRows(const Image& image, int first_row, const Finish& finish);

}  // namespace kiln
