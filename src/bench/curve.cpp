// Rate-distortion curves.
#include "curve.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tsc::bench {

namespace {

/// The points' coordinates sorted by x, of equal x the one with the lower y alone.
template <class X, class Y>
std::pair<std::vector<double>, std::vector<double>> sortedCoordinates(std::span<const RatePoint> points, X x, Y y) {
  std::vector<std::pair<double, double>> sorted;
  for (const RatePoint& point : points) {
    if (point.mse > 0 && point.bits > 0) sorted.emplace_back(x(point), y(point));
  }
  std::sort(sorted.begin(), sorted.end());
  std::pair<std::vector<double>, std::vector<double>> coordinates;
  for (const auto& [px, py] : sorted) {
    if (!coordinates.first.empty() && px - coordinates.first.back() < 1e-9) continue;
    coordinates.first.push_back(px);
    coordinates.second.push_back(py);
  }
  return coordinates;
}

double logBits(const RatePoint& point) { return std::log(point.bits); }
double logMse(const RatePoint& point) { return std::log(point.mse); }

/// Slope at an end of the curve: three-point formula, limited so that the end stays monotone.
double endSlope(double h0, double h1, double d0, double d1) {
  const double slope = ((2 * h0 + h1) * d0 - h0 * d1) / (h0 + h1);
  if (slope * d0 <= 0) return 0;
  if (d0 * d1 <= 0 && std::abs(slope) > 3 * std::abs(d0)) return 3 * d0;
  return slope;
}

}  // namespace

Pchip::Pchip(std::vector<double> x, std::vector<double> y) : x_(std::move(x)), y_(std::move(y)), slope_(x_.size()) {
  const std::size_t n = x_.size();
  std::vector<double> h(n - 1), d(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    h[i] = x_[i + 1] - x_[i];
    d[i] = (y_[i + 1] - y_[i]) / h[i];
  }
  if (n == 2) {
    slope_[0] = slope_[1] = d[0];
    return;
  }
  for (std::size_t i = 1; i + 1 < n; ++i) {
    if (d[i - 1] * d[i] <= 0) continue;
    const double w0 = 2 * h[i] + h[i - 1], w1 = h[i] + 2 * h[i - 1];
    slope_[i] = (w0 + w1) / (w0 / d[i - 1] + w1 / d[i]);
  }
  slope_[0] = endSlope(h[0], h[1], d[0], d[1]);
  slope_[n - 1] = endSlope(h[n - 2], h[n - 3], d[n - 2], d[n - 3]);
}

double Pchip::operator()(double x) const {
  const auto above = std::upper_bound(x_.begin() + 1, x_.end() - 1, x);
  const auto i = static_cast<std::size_t>(above - x_.begin()) - 1;
  const double h = x_[i + 1] - x_[i], t = (x - x_[i]) / h;
  const double t2 = t * t, t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * y_[i] + (t3 - 2 * t2 + t) * h * slope_[i] + (3 * t2 - 2 * t3) * y_[i + 1] +
         (t3 - t2) * h * slope_[i + 1];
}

std::optional<double> bdRate(std::span<const RatePoint> reference, std::span<const RatePoint> test) {
  auto [reference_x, reference_y] = sortedCoordinates(reference, logMse, logBits);
  auto [test_x, test_y] = sortedCoordinates(test, logMse, logBits);
  if (reference_x.size() < 2 || test_x.size() < 2) return std::nullopt;
  const Pchip reference_curve(reference_x, reference_y), test_curve(test_x, test_y);
  const double low = std::max(reference_curve.low(), test_curve.low());
  const double high = std::min(reference_curve.high(), test_curve.high());
  if (!(high > low)) return std::nullopt;
  constexpr int kSamples = 500;
  double sum = 0;
  for (int i = 0; i < kSamples; ++i) {
    const double x = low + (high - low) * (i + 0.5) / kSamples;
    sum += test_curve(x) - reference_curve(x);
  }
  return std::exp(sum / kSamples) - 1;
}

std::optional<double> mseAtRate(std::span<const RatePoint> curve, double bits) {
  auto [x, y] = sortedCoordinates(
      curve, [](const RatePoint& p) { return p.bits; }, logMse);
  if (x.size() < 2 || bits < x.front() || bits > x.back()) return std::nullopt;
  return std::exp(Pchip(x, y)(bits));
}

Spread spreadOf(std::vector<double> values) {
  Spread spread;
  if (values.empty()) return spread;
  std::sort(values.begin(), values.end());
  const auto quantile = [&](double q) {
    const double position = q * double(values.size() - 1);
    const auto i = static_cast<std::size_t>(position);
    return i + 1 < values.size() ? values[i] + (position - double(i)) * (values[i + 1] - values[i]) : values[i];
  };
  spread.count = values.size();
  spread.best = values.front();
  spread.low_quartile = quantile(0.25);
  spread.median = quantile(0.5);
  spread.high_quartile = quantile(0.75);
  spread.worst = values.back();
  for (const double value : values) spread.mean += value / double(values.size());
  return spread;
}

Spread ratioSpreadOf(const std::vector<double>& ratios) {
  Spread spread = spreadOf(ratios);
  double sum = 0;
  for (const double ratio : ratios) sum += std::log(std::max(ratio, 1e-300));
  if (!ratios.empty()) spread.mean = std::exp(sum / double(ratios.size()));
  return spread;
}

double medianOf(std::vector<double> values) { return spreadOf(std::move(values)).median; }

}  // namespace tsc::bench
