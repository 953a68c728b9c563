// Reads .gltf (with buffers in files or data URIs) and .glb files, as far as the tests of the extension need it.
import fs from 'node:fs';
import path from 'node:path';

const GLB_MAGIC = 0x46546c67;

/// {json, buffers, isGlb}; a buffer without bytes is null.
export function readAsset(file) {
  const bytes = fs.readFileSync(file);
  const isGlb = bytes.readUInt32LE(0) === GLB_MAGIC;
  let text = bytes;
  let bin = null;
  if (isGlb) {
    const jsonLength = bytes.readUInt32LE(12);
    text = bytes.subarray(20, 20 + jsonLength);
    const next = 20 + jsonLength;
    if (next < bytes.length) bin = bytes.subarray(next + 8, next + 8 + bytes.readUInt32LE(next));
  }
  const json = JSON.parse(text.toString());
  const buffers = (json.buffers ?? []).map((buffer, i) => {
    if (buffer.uri?.startsWith('data:')) return Buffer.from(buffer.uri.split(',')[1], 'base64');
    if (buffer.uri) return fs.readFileSync(path.join(path.dirname(file), decodeURIComponent(buffer.uri)));
    return i === 0 && isGlb ? bin : null;
  });
  return { json, buffers, isGlb };
}

/// The bytes of a buffer view, or null where its buffer has none.
export function viewBytes(asset, index) {
  const view = asset.json.bufferViews[index];
  const begin = view.byteOffset ?? 0;
  return asset.buffers[view.buffer]?.subarray(begin, begin + view.byteLength) ?? null;
}
