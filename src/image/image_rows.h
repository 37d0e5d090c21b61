// A picture as a sequence of bands of rows, for pictures larger than memory.
#pragma once

#include "base/progress.h"
#include "image/image.h"

namespace kiln {

/// shape: `height` rows of `width` pixels, row 0 at the top. Every band has the same channels.
class ImageRows {
 public:
  ImageRows(int w, int h) : width(w), height(h) {}
  virtual ~ImageRows() = default;
  ImageRows(const ImageRows&) = delete;
  ImageRows& operator=(const ImageRows&) = delete;

  struct Band {
    const Image* image = nullptr;
    int first_row = 0;  // row of the picture that is row 0 of the image
    int end() const { return first_row + image->height; }
  };
  /// Returns the band that holds a row, valid until the next call. throws: Error kIo, kDamaged.
  virtual Band bandAt(int row) = 0;

  const int width, height;
};

/// An image in memory as one band.
class RowsOfImage : public ImageRows {
 public:
  /// requires: the image outlives this.
  explicit RowsOfImage(const Image& image) : ImageRows(image.width, image.height), image_(image) {}
  Band bandAt(int /*row*/) override { return {&image_, 0}; }

 private:
  const Image& image_;
};

/// Rows of a picture until the user requests a stop.
class RowsUntilStopped : public ImageRows {
 public:
  /// requires: both outlive this.
  RowsUntilStopped(ImageRows& rows, const Progress& progress)
      : ImageRows(rows.width, rows.height), rows_(rows), progress_(progress) {}
  /// throws: Error kCancelled; as the rows.
  Band bandAt(int row) override {
    progress_.throwIfCancelled("encoding the picture");
    return rows_.bandAt(row);
  }

 private:
  ImageRows& rows_;
  const Progress& progress_;
};

}  // namespace kiln
