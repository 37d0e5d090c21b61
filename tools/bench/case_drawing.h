// Draws frames of a suite's case, from any view by any method; holds the case's store, cache and transfer function.
#pragma once

#include <filesystem>
#include <memory>

#include "bench/suite.h"
#include "bench/views.h"
#include "frame/render_frame.h"
#include "store/store_reader.h"

namespace kiln {

struct MeasuredFrame {
  Image image;
  FrameStatistics statistics;    // statistics of the last draw
  std::vector<double> render_s;  // wall time without loading, for each draw
  double medianSeconds() const;
  double leastSeconds() const;
};

class CaseDrawing {
 public:
  /// requires: suite and case outlive it. throws: the exceptions of StoreReader, BrickCache and the transfer function.
  CaseDrawing(const Suite& suite, const SuiteCase& c, const std::filesystem::path& store, Progress& progress);

  const StoreReader& store() const { return store_; }
  std::vector<SuiteView> views(const ImageSize& size, Projection projection) const;

  /// Returns the suite's visibility options for `method`.
  VisibilityOptions optionsFor(VisibilityMethod method, int epsilon_px = 0) const;
  /// Draws the view `repeat` times. throws: the exceptions of renderFrame.
  MeasuredFrame draw(const View& view, const VisibilityOptions& visibility, int repeat, NodeLog* log = nullptr);
  /// Reads every brick with visible values, as far as the budget allows.
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
