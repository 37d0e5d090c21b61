// One case of a suite, ready to be drawn: its store and bricks, its material, and a frame of any view by any method.
#pragma once

#include <filesystem>
#include <memory>

#include "bench/suite.h"
#include "bench/views.h"
#include "frame/render_frame.h"

namespace kiln {

struct MeasuredFrame {
  Image image;
  FrameStatistics statistics;    // of the last draw
  std::vector<double> render_s;  // one a draw: wall time without loading
  double medianSeconds() const;
  double leastSeconds() const;
};

class CaseDrawing {
 public:
  /// requires: suite and case outlive it. throws: what StoreReader, BrickCache and the transfer function throw.
  CaseDrawing(const Suite& suite, const SuiteCase& c, const std::filesystem::path& store, Progress& progress);

  const StoreReader& store() const { return store_; }
  std::vector<SuiteView> views(const ImageSize& size, Projection projection) const;

  /// The options by which the suite draws with `method`.
  VisibilityOptions optionsFor(VisibilityMethod method, int epsilon_px = 0) const;
  /// Draws the view `repeat` times. throws: what renderFrame throws.
  MeasuredFrame draw(const View& view, const VisibilityOptions& visibility, int repeat, NodeLog* log = nullptr);
  /// Reads every brick that the transfer function shows something of, as far as the budget goes.
  void warmUp();

 private:
  const Suite& suite_;
  const SuiteCase& case_;
  StoreReader store_;
  BrickCache cache_;
  TransferFunction transfer_function_;
  Progress& progress_;
};

}  // namespace kiln
