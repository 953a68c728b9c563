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

/// What the payload holds.
struct Payload {
  Assignment assignment;
  Buffer<VertexState> states;   ///< of the surface's positions, where only the outputs need these
  std::vector<Vec3> positions;  ///< the others
};

bool needEdges(const PositionParameters& p) { return p.effort == Effort::kMax || p.predictor == Predictor::kWeighted; }

void forgetEdges(Surface& surface) {
  surface.opposite = Buffer<std::uint32_t>();
  surface.vertex_corner = Buffer<std::uint32_t>();
}

/// The surface and its positions.
Status decodeSurface(const Header& header, EntropyReader& reader, Surface& surface, PositionMap& map,
                     Payload& payload) {
  const PositionParameters& parameters = header.positions;
  // Then nothing after the positions needs edges, nor a position but for its place in the output.
  const bool ends_here = header.counts.one_vertex_per_position && header.counts.primitive_face_count.size() == 1 &&
                         parameters.order == Order::kTraversal;
  const bool has_edges = !ends_here || needEdges(parameters) || header.has_references;
  if (Status s = has_edges ? decodeConnectivity(reader, parameters.effort, header.surface, surface)
                           : decodeConnectivity(reader, header.surface, surface, payload.states)) {
    return s;
  }
  if (Status s = decodeReferences(surface, header.has_references, reader, map)) return s;
  const CodingOrder order = codingOrder(surface, map, parameters.order);
  if (has_edges) {
    payload.states.resize(map.position_count);
    collectStencils(order, payload.states);
    if (ends_here && !needEdges(parameters)) forgetEdges(surface);
  }
  if (Status s = decodePositions(order, parameters, reader, payload.states)) return s;
  if (ends_here) {
    forgetEdges(surface);
  } else {
    payload.positions = pointsOf(order, payload.states);
    payload.states = Buffer<VertexState>();
  }
  return {};
}

Status decodePayload(const Header& header, EntropyReader& reader, Payload& payload) {
  Surface surface;
  PositionMap map;
  if (Status s = decodeSurface(header, reader, surface, map, payload)) return s;
  Assignment& assignment = payload.assignment;
  if (Status s = decodeAssignment(std::move(surface), map, payload.positions, header.counts, reader, assignment)) {
    return s;
  }
  payload.positions.resize(assignment.position_count - payload.states.size());
  return decodeExtraPositions(reader, extraPositionBits(header.positions),
                              std::span(payload.positions).last(assignment.position_count - map.position_count));
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

/// All stages. `provide` gives the array of an output. It is first called when the payload has been decoded, and so
/// holds as much as the header claims, and for each output when those before it are complete.
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
  Payload payload;
  if (Status s = decodePayload(header, reader, payload)) {
    s->byte_offset = header_size + reader.position();
    return s;
  }
  if (!reader.atEnd()) {
    return Error{reader.overrun() ? ErrorCode::kTruncated : ErrorCode::kTrailingData, "end of stream",
                 header_size + reader.position(), static_cast<std::int64_t>(stream.size()),
                 static_cast<std::int64_t>(header_size + reader.position())};
  }
  std::vector<std::span<std::byte>> outputs;
  for (const std::vector<std::uint32_t>& numbers : payload.assignment.table_position) {
    outputs.push_back(provide(infos[outputs.size()]));
    if (Status s = writePositions(header, numbers, {payload.states, payload.positions}, outputs.back())) {
      s->byte_offset = stream.size();
      return s;
    }
  }
  payload.states = Buffer<VertexState>();
  payload.positions = std::vector<Vec3>();
  for (Buffer<std::uint32_t>& indices : payload.assignment.primitive_indices) {
    const OutputInfo& info = infos[outputs.size()];
    outputs.push_back(provide(info));
    writeIndices(info.type, indices, outputs.back());
    indices = Buffer<std::uint32_t>();
  }
  const std::uint32_t expected = checksumOf(stream.first(header_size), outputs);
  if (reader.state() != finalState(expected)) {
    const auto found = static_cast<std::int64_t>(reader.state() ^ kCoderStateMin);
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
  std::size_t next = 0;
  return decodeStream(
      stream, limits, [&](const OutputInfo&) { return outputs[next++]; }, outputs);
}

Result<std::vector<std::vector<std::byte>>> decode(std::span<const std::byte> stream, const DecodeLimits& limits) {
  std::vector<std::vector<std::byte>> outputs;
  const auto allocate = [&](const OutputInfo& info) {
    return std::span(outputs.emplace_back(static_cast<std::size_t>(info.byte_length)));
  };
  if (Status s = decodeStream(stream, limits, allocate, {})) return *s;
  return outputs;
}

}  // namespace tsc
