// See container.h. GLB: glTF 2.0, section 4.4.
#include "container.h"

#include <array>
#include <cstring>

#include "fault.h"

namespace tsc {
namespace {

constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kChunkHeaderBytes = 8;

std::uint32_t readU32(std::span<const std::byte> bytes, std::size_t offset) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(bytes[offset + i]) << (8 * i);
  return value;
}

void appendU32(std::vector<std::byte>& out, std::uint32_t value) {
  for (int i = 0; i < 4; ++i) out.push_back(static_cast<std::byte>(value >> (8 * i)));
}

std::string atByte(std::size_t offset) { return "byte " + std::to_string(offset); }

void appendChunk(std::vector<std::byte>& out, std::uint32_t type, std::span<const std::byte> bytes, std::byte padding) {
  const std::size_t padded = (bytes.size() + 3) / 4 * 4;
  appendU32(out, static_cast<std::uint32_t>(padded));
  appendU32(out, type);
  out.insert(out.end(), bytes.begin(), bytes.end());
  out.insert(out.end(), padded - bytes.size(), padding);
}

constexpr char kBase64[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
constexpr std::uint8_t kNotBase64 = 255;

constexpr std::array<std::uint8_t, 256> makeBase64Values() {
  std::array<std::uint8_t, 256> values{};
  values.fill(kNotBase64);
  for (std::uint8_t i = 0; i < 64; ++i) values[static_cast<unsigned char>(kBase64[i])] = i;
  return values;
}

std::vector<std::byte> decodeBase64(std::string_view text, std::string_view place) {
  static constexpr std::array<std::uint8_t, 256> kValues = makeBase64Values();
  while (!text.empty() && text.back() == '=') text.remove_suffix(1);
  std::vector<std::byte> out;
  out.reserve(text.size() * 3 / 4);
  std::uint32_t buffer = 0;
  int bits = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::uint8_t value = kValues[static_cast<unsigned char>(text[i])];
    if (value == kNotBase64) {
      failInvalid(place, "found character code " + std::to_string(static_cast<unsigned char>(text[i])) +
                             " at base64 position " + std::to_string(i) + ", expected a base64 digit");
    }
    buffer = (buffer << 6) | value;
    bits += 6;
    if (bits >= 8) {
      bits -= 8;
      out.push_back(static_cast<std::byte>(buffer >> bits));
    }
  }
  return out;
}

int hexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

bool isGlb(std::span<const std::byte> bytes) { return bytes.size() >= 4 && readU32(bytes, 0) == kGlbMagic; }

Glb parseGlb(std::span<const std::byte> bytes) {
  if (bytes.size() < kHeaderBytes + kChunkHeaderBytes) {
    failInvalid(atByte(bytes.size()), "the file ends inside the GLB header, expected at least 20 bytes");
  }
  if (readU32(bytes, 4) != 2) {
    fail(FailureKind::kUnsupported, atByte(4),
         "found GLB version " + std::to_string(readU32(bytes, 4)) + ", expected 2");
  }
  const std::size_t length = readU32(bytes, 8);
  if (length > bytes.size() || length < kHeaderBytes + kChunkHeaderBytes) {
    failInvalid(atByte(8), "found a GLB length of " + std::to_string(length) + ", expected " +
                               std::to_string(bytes.size()) + ", the size of the file");
  }
  Glb glb;
  bool have_json = false;
  for (std::size_t at = kHeaderBytes; at < length;) {
    if (length - at < kChunkHeaderBytes) failInvalid(atByte(at), "the file ends inside a GLB chunk header");
    const std::size_t chunk_length = readU32(bytes, at);
    const std::uint32_t type = readU32(bytes, at + 4);
    if (chunk_length > length - at - kChunkHeaderBytes) {
      failInvalid(atByte(at), "found a GLB chunk of " + std::to_string(chunk_length) + " bytes, expected at most the " +
                                  std::to_string(length - at - kChunkHeaderBytes) + " that remain");
    }
    const auto chunk = bytes.subspan(at + kChunkHeaderBytes, chunk_length);
    if (!have_json) {
      if (type != kGlbJsonChunk) failInvalid(atByte(at + 4), "found another chunk first, expected the JSON chunk");
      glb.json = {reinterpret_cast<const char*>(chunk.data()), chunk.size()};
      have_json = true;
    } else if (type == kGlbBinChunk && !glb.bin && glb.extra_chunks.empty()) {
      glb.bin = chunk;
    } else {
      glb.extra_chunks.push_back({type, {chunk.begin(), chunk.end()}});
    }
    at += kChunkHeaderBytes + chunk_length;
  }
  return glb;
}

std::vector<std::byte> buildGlb(std::string_view json, std::optional<std::span<const std::byte>> bin,
                                std::span<const GlbChunk> extra_chunks) {
  std::uint64_t total = kHeaderBytes + kChunkHeaderBytes + json.size() + 3;
  if (bin) total += kChunkHeaderBytes + bin->size() + 3;
  for (const GlbChunk& chunk : extra_chunks) total += kChunkHeaderBytes + chunk.bytes.size() + 3;
  if (total > UINT32_MAX) {
    fail(FailureKind::kUnsupported, "",
         "the GLB file would take " + std::to_string(total) +
             " bytes, at most 4294967295 are possible; write .gltf instead");
  }
  std::vector<std::byte> out;
  out.reserve(total);
  appendU32(out, kGlbMagic);
  appendU32(out, 2);
  appendU32(out, 0);
  appendChunk(out, kGlbJsonChunk, std::as_bytes(std::span(json)), std::byte{' '});
  if (bin) appendChunk(out, kGlbBinChunk, *bin, std::byte{0});
  for (const GlbChunk& chunk : extra_chunks) appendChunk(out, chunk.type, chunk.bytes, std::byte{0});
  const auto length = static_cast<std::uint32_t>(out.size());
  for (std::size_t i = 0; i < 4; ++i) out[8 + i] = static_cast<std::byte>(length >> (8 * i));
  return out;
}

bool isDataUri(std::string_view uri) {
  return uri.size() >= 5 && (uri.substr(0, 5) == "data:" || percentDecode(uri.substr(0, 5)) == "data:");
}

std::vector<std::byte> decodeDataUri(std::string_view uri, std::string_view place) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string_view::npos) failInvalid(place, "found a data URI without a comma");
  const std::string_view header = uri.substr(0, comma);
  const std::string_view body = uri.substr(comma + 1);
  constexpr std::string_view kBase64Mark = ";base64";
  if (header.size() >= kBase64Mark.size() && header.substr(header.size() - kBase64Mark.size()) == kBase64Mark) {
    const bool encoded = body.find('%') != std::string_view::npos;
    return encoded ? decodeBase64(percentDecode(body), place) : decodeBase64(body, place);
  }
  const std::string text = percentDecode(body);
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

std::string encodeDataUri(std::span<const std::byte> bytes) {
  std::string out = "data:application/octet-stream;base64,";
  out.reserve(out.size() + (bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = (group << 8) | (i + k < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i + k]) : 0);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      const bool padding = i + k > bytes.size();
      out += padding ? '=' : kBase64[(group >> (18 - 6 * k)) & 63];
    }
  }
  return out;
}

std::string percentDecode(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '%' && i + 2 < text.size() && hexDigit(text[i + 1]) >= 0 && hexDigit(text[i + 2]) >= 0) {
      out += static_cast<char>(hexDigit(text[i + 1]) * 16 + hexDigit(text[i + 2]));
      i += 2;
    } else {
      out += text[i];
    }
  }
  return out;
}

std::string percentEncode(std::string_view file_name) {
  constexpr std::string_view kPlain = "-._~!$&'()*+,;=@";
  constexpr char kHex[] = "0123456789ABCDEF";
  std::string out;
  for (const char c : file_name) {
    const auto code = static_cast<unsigned char>(c);
    const bool alphanumeric = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (alphanumeric || kPlain.find(c) != std::string_view::npos) {
      out += c;
    } else {
      out += {'%', kHex[code >> 4], kHex[code & 15]};
    }
  }
  return out;
}

}  // namespace tsc
