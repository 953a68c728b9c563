// See precision.h.
#include "precision.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "fault.h"

namespace tsc {
namespace {

constexpr int kMaxPositionBits = 24;
constexpr std::uint32_t kMaxNormalScale = 16;

std::string print(double value) { return Json(value).dump(); }

EncodeOptions withStep(EncodeOptions options, double step) {
  options.step = step;
  return options;
}

/// The largest float step whose guaranteed error is at most `bound`. Positive floats are ordered as their bit patterns
/// are, so that this is a search over 31 bits.
double largestStepWithin(const Mesh& mesh, const EncodeOptions& options, double bound, const std::string& label) {
  const auto holds = [&](std::uint32_t bits) {
    return guaranteedError(mesh, withStep(options, std::bit_cast<float>(bits))) <= bound;
  };
  std::uint32_t low = std::bit_cast<std::uint32_t>(std::numeric_limits<float>::min());
  std::uint32_t high = std::bit_cast<std::uint32_t>(std::numeric_limits<float>::max() / 8);
  if (!holds(low)) {
    fail(FailureKind::kBound, label,
         "found no step that keeps an error of " + print(bound) +
             "; float coordinates of this size are coarser than that");
  }
  while (high - low > 1) {
    const std::uint32_t middle = low + (high - low) / 2;
    (holds(middle) ? low : high) = middle;
  }
  return std::bit_cast<float>(low);
}

std::uint64_t vertexCount(const Mesh& mesh) {
  std::uint64_t count = 0;
  for (const VertexTable& table : mesh.tables) count += table.positions.size() / 3;
  return count;
}

/// The step at which the stream takes about `target` bits per vertex, from the finer side of the search: not above it,
/// unless even the coarsest step is.
double stepForRate(const Mesh& mesh, const EncodeOptions& options, double target) {
  constexpr int kIterations = 14;
  constexpr double kTolerance = 0.005;
  const double vertices = static_cast<double>(std::max<std::uint64_t>(vertexCount(mesh), 1));
  double fine = stepForBits(mesh, kMaxPositionBits);
  double coarse = stepForBits(mesh, 1);
  double best = coarse;
  for (int i = 0; i < kIterations && coarse / fine > 1.0005; ++i) {
    const double step = std::sqrt(fine * coarse);
    const Result<EncodeResult> result = encode(mesh, withStep(options, step));
    const double rate =
        result ? static_cast<double>(result->bytes.size()) * 8 / vertices : std::numeric_limits<double>::infinity();
    if (rate <= target) {
      best = coarse = step;
      if (rate > target * (1 - kTolerance)) break;
    } else {
      fine = step;
    }
  }
  return best;
}

}  // namespace

double diagonalOf(const Mesh& mesh) {
  std::array<double, 3> low, high;
  low.fill(std::numeric_limits<double>::infinity());
  high.fill(-std::numeric_limits<double>::infinity());
  for (const VertexTable& table : mesh.tables) {
    for (std::size_t i = 0; i < table.positions.size(); ++i) {
      const double value = table.positions[i];
      low[i % 3] = std::min(low[i % 3], value);
      high[i % 3] = std::max(high[i % 3], value);
    }
  }
  double square = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (high[axis] > low[axis]) square += (high[axis] - low[axis]) * (high[axis] - low[axis]);
  }
  return std::sqrt(square);
}

void checkPackOptions(const PackOptions& options) {
  const double value = options.precision.value;
  if (options.precision.kind == Precision::Kind::kPositionBits) {
    if (!(value >= 1 && value <= kMaxPositionBits && std::floor(value) == value)) {
      fail(FailureKind::kUsage, "", "found " + print(value) + " position bits, expected 1 to 24");
    }
  } else if (!(value > 0 && value <= static_cast<double>(std::numeric_limits<float>::max()))) {
    fail(FailureKind::kUsage, "", "found a precision of " + print(value) + ", expected a positive number");
  }
  if (options.normal_scale < 1 || options.normal_scale > kMaxNormalScale) {
    fail(FailureKind::kUsage, "",
         "found a normal scale of " + std::to_string(options.normal_scale) + ", expected 1 to 16");
  }
}

EncodeOptions chooseEncodeOptions(const Mesh& mesh, const PackOptions& options, const std::string& label) {
  EncodeOptions encode_options;
  encode_options.normal_scale = options.normal_scale;
  encode_options.mode = options.mode;
  encode_options.basis = options.basis;
  encode_options.predictor = options.predictor;
  encode_options.order = options.order;
  encode_options.effort = options.effort;
  encode_options.step = 1;
  if (mesh.position_type != ComponentType::kFloat32) return encode_options;
  const double value = options.precision.value;
  switch (options.precision.kind) {
    case Precision::Kind::kPositionBits:
      encode_options.step = stepForBits(mesh, static_cast<int>(value));
      break;
    case Precision::Kind::kStep:
      encode_options.step = value;
      encode_options.anchored = true;
      break;
    case Precision::Kind::kMaxError:
      encode_options.step = largestStepWithin(mesh, encode_options, value, label);
      break;
    case Precision::Kind::kRelativeError: {
      const double diagonal = diagonalOf(mesh);
      if (diagonal > 0) encode_options.step = largestStepWithin(mesh, encode_options, value * diagonal, label);
      break;
    }
    case Precision::Kind::kTargetBpv:
      encode_options.step = stepForRate(mesh, encode_options, value);
      break;
  }
  return encode_options;
}

}  // namespace tsc
