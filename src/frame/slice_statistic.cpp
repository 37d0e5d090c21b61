#include "frame/slice_statistic.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.h"

namespace kiln {
namespace {

class Mean final : public SliceStatistic {
 public:
  double valueOf(const GatheredValue& pixel) const override { return pixel.value / pixel.samples; }

 private:
  double combined(double held, double value) const override { return held + value; }
};

class Greatest final : public SliceStatistic {
 public:
  int sign() const override { return 1; }

 private:
  double combined(double held, double value) const override { return std::max(held, value); }
};

class Least final : public SliceStatistic {
 public:
  int sign() const override { return -1; }

 private:
  double combined(double held, double value) const override { return std::min(held, value); }
};

}  // namespace

void SliceStatistic::add(double value, GatheredValue& pixel) const {
  if (std::isnan(value)) return;
  pixel.value = pixel.samples == 0 ? value : combined(pixel.value, value);
  ++pixel.samples;
}

const SliceStatistic& sliceStatistic(std::string_view name) {
  static const Mean mean;
  static const Greatest greatest;
  static const Least least;
  if (name == "average") return mean;
  if (name == "mip") return greatest;
  if (name == "minip") return least;
  throw Error(ErrorCode::kUsage, fmt::format("--mode: expected average, mip or minip (found '{}')", name));
}

}  // namespace kiln
