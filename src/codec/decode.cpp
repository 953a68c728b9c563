// Decoding, stage by stage in the order of BITSTREAM.md: header (2), connectivity (5), references (7.1), positions (6),
// faces and corners (7), extra positions (6.8), outputs and checksum (8).
#include <optional>

#include "connectivity.h"
#include "entropy.h"
#include "extra_positions.h"
#include "format.h"
#include "header.h"
#include "output.h"

namespace tsc {
namespace {

Status decodePayload(const Header& header, EntropyReader& reader, Assignment& assignment,
                     std::vector<Vec3>& positions) {
  Surface surface;
  if (Status s = decodeConnectivity(reader, header.positions.effort, header.surface, surface)) return s;
  PositionMap map;
  if (Status s = decodeReferences(surface, header.has_references, reader, map)) return s;
  const bool edges_end_here = header.counts.one_vertex_per_position && header.counts.primitive_face_count.size() == 1;
  if (edges_end_here && header.positions.order == Order::kTraversal) {
    surface.vertex_corner = std::vector<std::uint32_t>();  // not needed again
  }
  if (Status s = decodePositions(surface, map, header.positions, edges_end_here, reader, positions)) return s;
  if (Status s = decodeAssignment(std::move(surface), map, positions, header.counts, reader, assignment)) return s;
  positions.resize(assignment.position_count);
  return decodeExtraPositions(reader, extraPositionBits(header.positions),
                              std::span(positions).subspan(map.position_count));
}

Status checkOutputs(std::span<const OutputInfo> infos, std::span<const std::span<std::byte>> outputs) {
  if (outputs.size() != infos.size()) {
    return Error{ErrorCode::kOutputMismatch, "number of outputs", 0, static_cast<std::int64_t>(outputs.size()),
                 static_cast<std::int64_t>(infos.size())};
  }
  for (std::size_t i = 0; i < infos.size(); ++i) {
    if (outputs[i].size() != infos[i].byte_length) {
      return Error{ErrorCode::kOutputMismatch, "bytes of an output", 0, static_cast<std::int64_t>(outputs[i].size()),
                   static_cast<std::int64_t>(infos[i].byte_length)};
    }
  }
  return {};
}

/// All stages. `provide` gives the arrays when the payload has been decoded, and so holds as much as the header claims;
/// `known` are the same arrays where the caller has them already.
template <class Provide>
Status decodeStream(std::span<const std::byte> stream, const DecodeLimits& limits, Provide&& provide,
                    std::optional<std::span<const std::span<std::byte>>> known) {
  Header header;
  std::size_t header_size = 0;
  if (Status s = readHeader(stream, limits, header, header_size)) return s;
  const std::vector<OutputInfo> infos = outputsOf(header);
  if (known) {
    if (Status s = checkOutputs(infos, *known)) return s;
  }
  EntropyReader reader(stream.subspan(header_size));
  Assignment assignment;
  std::vector<Vec3> positions;
  if (Status s = decodePayload(header, reader, assignment, positions)) {
    s->byte_offset = header_size + reader.position();
    return s;
  }
  if (!reader.atEnd()) {
    return Error{reader.overrun() ? ErrorCode::kTruncated : ErrorCode::kTrailingData, "end of stream",
                 header_size + reader.position(), static_cast<std::int64_t>(stream.size()),
                 static_cast<std::int64_t>(header_size + reader.position())};
  }
  const std::span<const std::span<std::byte>> outputs = provide(infos);
  if (Status s = writeOutputs(header, assignment, positions, outputs)) {
    s->byte_offset = stream.size();
    return s;
  }
  const std::uint32_t expected = checksumOf(stream.first(header_size), outputs);
  if (reader.states() != finalStates(expected)) {
    const std::uint32_t found = (reader.states()[0] - kCoderStateMin) | (reader.states()[1] - kCoderStateMin) << 16;
    return Error{ErrorCode::kChecksumMismatch, "checksum", stream.size(), found, expected};
  }
  return {};
}

}  // namespace

Result<StreamInfo> readStreamInfo(std::span<const std::byte> stream, const DecodeLimits& limits) {
  Header header;
  std::size_t size = 0;
  if (Status s = readHeader(stream, limits, header, size)) return *s;
  StreamInfo info;
  info.version = kFormatVersion;
  const PositionParameters& p = header.positions;
  info.modes = {p.mode, p.basis, p.predictor, p.order, p.effort, p.normal_scale, double{header.step}};
  info.outputs = outputsOf(header);
  return info;
}

Status decode(std::span<const std::byte> stream, std::span<const std::span<std::byte>> outputs,
              const DecodeLimits& limits) {
  return decodeStream(
      stream, limits, [&](std::span<const OutputInfo>) { return outputs; }, outputs);
}

Result<std::vector<std::vector<std::byte>>> decode(std::span<const std::byte> stream, const DecodeLimits& limits) {
  std::vector<std::vector<std::byte>> outputs;
  std::vector<std::span<std::byte>> spans;
  const auto allocate = [&](std::span<const OutputInfo> infos) {
    for (const OutputInfo& info : infos)
      spans.emplace_back(outputs.emplace_back(static_cast<std::size_t>(info.byte_length)));
    return std::span<const std::span<std::byte>>(spans);
  };
  if (Status s = decodeStream(stream, limits, allocate, {})) return *s;
  return outputs;
}

}  // namespace tsc
