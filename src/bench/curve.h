// Rate-distortion curves: interpolation, and the figures drawn from two of them.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace tsc::bench {

struct RatePoint {
  double bits = 0;  ///< of the whole stream
  double mse = 0;   ///< mean squared vertex error, in squared position units
};

/// Piecewise cubic Hermite interpolation that keeps monotone data monotone (Fritsch & Carlson 1980, as in Matlab's
/// `pchip`). Abscissae strictly increase; at least two points.
class Pchip {
 public:
  Pchip(std::vector<double> x, std::vector<double> y);
  double operator()(double x) const;
  double low() const { return x_.front(); }
  double high() const { return x_.back(); }

 private:
  std::vector<double> x_, y_, slope_;
};

/// Bjontegaard's delta rate: exp(mean difference of log bits) - 1 at equal MSE, over the range of log MSE that both
/// curves cover, log bits interpolated over log MSE by `Pchip`. -0.2 means: `test` needs 20% fewer bits. Empty when the
/// ranges do not overlap. Points without error are left out: they have no logarithm.
std::optional<double> bdRate(std::span<const RatePoint> reference, std::span<const RatePoint> test);

/// MSE of a curve at a rate: log MSE interpolated over bits. Empty outside the curve.
std::optional<double> mseAtRate(std::span<const RatePoint> curve, double bits);

struct Spread {
  double median = 0, mean = 0, worst = 0, low_quartile = 0, high_quartile = 0, best = 0;
  std::size_t count = 0;
};
/// Of values where less is better; all zero when there are none.
Spread spreadOf(std::vector<double> values);

/// Geometric mean instead of the mean: for ratios.
Spread ratioSpreadOf(const std::vector<double>& ratios);

double medianOf(std::vector<double> values);

}  // namespace tsc::bench
