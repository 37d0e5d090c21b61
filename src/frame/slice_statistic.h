// Reduces the samples across a thick slice to one value for each pixel: their mean, greatest or least value.
#pragma once

#include <cstdint>
#include <string_view>

namespace kiln {

/// The samples of a pixel so far. A statistic defines the meaning of `value`.
struct GatheredValue {
  double value = 0;
  std::uint32_t samples = 0;
};

/// A way to reduce samples. Threads may share an instance.
class SliceStatistic {
 public:
  virtual ~SliceStatistic() = default;

  /// Adds a sample to a pixel. NaN is ignored.
  void add(double value, GatheredValue& pixel) const;
  /// Returns the value of a pixel that has at least one sample.
  virtual double valueOf(const GatheredValue& pixel) const { return pixel.value; }
  /// 1: the greatest value; -1: the least value; 0: neither.
  virtual int sign() const { return 0; }
  /// Returns true if the result may differ from all samples: labels have no such statistic.
  bool mixesValues() const { return sign() == 0; }

 private:
  // The new value of a pixel that holds at least one sample.
  virtual double combined(double held, double value) const = 0;
};

/// Returns the statistic called average, mip or minip. throws: Error kUsage that names --mode.
const SliceStatistic& sliceStatistic(std::string_view name);

}  // namespace kiln
