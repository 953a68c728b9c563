// The numbered rules for assets in extension-spec/README.md ("Conformance"), as checks of one packed asset.
import { viewBytes } from './asset.mjs';

const EXTENSION = 'EXT_mesh_tangentspace_compression';
const MESHOPT = ['EXT_meshopt_compression', 'KHR_meshopt_compression'];
const ARRAY_BUFFER = 34962;
const ELEMENT_ARRAY_BUFFER = 34963;
const TRIANGLES = 4;
const COMPONENTS = {
  int8: [5120, 1], uint8: [5121, 1], int16: [5122, 2], uint16: [5123, 2], uint32: [5125, 4], float32: [5126, 4],
};

const extensionOf = (holder) => holder.extensions?.[EXTENSION];
const isMarked = (buffer) => extensionOf(buffer)?.fallback === true;

/// Type, count and layout of an output as `gltf-tsc inspect --json` lists it.
function layoutOf(output) {
  const [componentType, bytes] = COMPONENTS[output.type];
  const isPositions = output.kind === 'positions';
  const stride = isPositions ? Math.ceil(3 * bytes / 4) * 4 : bytes;
  return { isPositions, componentType, stride, packed: stride === (isPositions ? 3 * bytes : bytes), count: output.count,
    byteLength: output.byteLength };
}

/// Every place in the document that refers to a buffer view, as [pointer, index].
function viewReferences(value, pointer = '') {
  if (value === null || typeof value !== 'object') return [];
  return Object.entries(value).flatMap(([key, member]) => {
    const place = `${pointer}/${key}`;
    return key === 'bufferView' && typeof member === 'number' ? [[place, member]] : viewReferences(member, place);
  });
}

function checkStreamViews(asset, compressed, report) {
  const { json } = asset;
  const orders = new Map();
  for (const { extension } of compressed) {
    const order = extension.order?.bufferView;
    if (orders.has(extension.bufferView) && orders.get(extension.bufferView) !== order) report(13, `order ${order}`);
    orders.set(extension.bufferView, order);
  }
  for (const named of new Set([...orders].flat().filter((index) => index !== undefined))) {
    const view = json.bufferViews[named];
    if (!view) { report(2, `buffer view ${named} does not exist`); continue; }
    if (extensionOf(view) || MESHOPT.some((name) => view.extensions?.[name])) report(2, `${named} is compressed`);
    if ('byteStride' in view || 'target' in view) report(2, `${named} has byteStride or target`);
    if (!viewBytes(asset, named)) report(2, `${named} has no bytes`);
    for (const [place, index] of viewReferences(json)) {
      const ours = place.endsWith(`/${EXTENSION}/bufferView`) || place.endsWith(`/${EXTENSION}/order/bufferView`);
      if (index === named && !ours) report(2, `${place} refers to ${named}`);
    }
  }
}

function checkCompressedViews(compressed, report) {
  const named = new Set();
  for (const { index, view, extension, output } of compressed) {
    const key = `${extension.bufferView}/${extension.output}`;
    if (!output || named.has(key)) report(4, `buffer view ${index}: output ${key}`);
    named.add(key);
    if (!output) continue;
    if (view.byteLength !== output.byteLength) report(5, `buffer view ${index}: ${view.byteLength}`);
    const strideFits = output.isPositions
      ? view.byteStride === output.stride || (view.byteStride === undefined && output.packed)
      : view.byteStride === undefined;
    if (!strideFits) report(6, `buffer view ${index}: byteStride ${view.byteStride}`);
    const target = output.isPositions ? ARRAY_BUFFER : ELEMENT_ARRAY_BUFFER;
    if ((view.target ?? target) !== target) report(6, `buffer view ${index}: target ${view.target}`);
    if (MESHOPT.some((name) => view.extensions[name])) report('exclusions', `buffer view ${index}`);
  }
}

function checkAccessors(json, byView, report) {
  json.accessors.forEach((accessor, i) => {
    const output = byView.get(accessor.bufferView)?.output;
    if (!output) return;
    const fits = accessor.componentType === output.componentType && accessor.count === output.count &&
      accessor.type === (output.isPositions ? 'VEC3' : 'SCALAR') && !accessor.byteOffset && !accessor.sparse;
    if (!fits) report(7, `accessor ${i}: ${JSON.stringify(accessor)}`);
  });
}

function checkPrimitives(json, byView, report) {
  const compressedView = (accessor) => byView.get(json.accessors[accessor]?.bufferView);
  json.meshes.forEach((mesh, m) => mesh.primitives.forEach((primitive, p) => {
    const place = `meshes/${m}/primitives/${p}`;
    const indices = compressedView(primitive.indices);
    const positions = compressedView(primitive.attributes.POSITION);
    if ((indices || positions) && primitive.extensions?.KHR_draco_mesh_compression) report(9, `${place}: Draco`);
    if (!indices) return;
    if ((primitive.mode ?? TRIANGLES) !== TRIANGLES) report(9, `${place}: mode ${primitive.mode}`);
    const together = positions?.output?.isPositions && positions.extension.bufferView === indices.extension.bufferView;
    if (!together) report(9, `${place}: POSITION is not in the stream of the indices`);
  }));
}

function checkBuffers(asset, compressed, report) {
  const { json, buffers, isGlb } = asset;
  const ends = new Map();
  const byOffset = [...compressed].sort((a, b) => (a.view.byteOffset ?? 0) - (b.view.byteOffset ?? 0));
  for (const { index, view } of byOffset) {
    const begin = view.byteOffset ?? 0;
    if (begin < (ends.get(view.buffer) ?? 0)) report(10, `buffer view ${index} overlaps another`);
    ends.set(view.buffer, begin + view.byteLength);
    if (buffers[view.buffer]) continue;
    const buffer = json.buffers[view.buffer];
    if ('uri' in buffer || !isMarked(buffer) || (isGlb && view.buffer === 0)) report(10, `buffer ${view.buffer}`);
    if (buffer.byteLength < begin + view.byteLength) report(10, `buffer ${view.buffer}: byteLength`);
    if (!json.extensionsRequired?.includes(EXTENSION)) report(1, 'not in extensionsRequired');
  }
  json.bufferViews.forEach((view, i) => {
    if (isMarked(json.buffers[view.buffer]) && !extensionOf(view)) report(11, `buffer view ${i}`);
  });
}

/// Bounds of x, y and z over a positions output.
function boundsOf(bytes, output) {
  const read = { 5120: 'readInt8', 5121: 'readUInt8', 5122: 'readInt16LE', 5123: 'readUInt16LE', 5126: 'readFloatLE' };
  const size = output.componentType === 5126 ? 4 : output.componentType >= 5122 ? 2 : 1;
  const min = [Infinity, Infinity, Infinity];
  const max = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < output.count; ++i) {
    for (let axis = 0; axis < 3; ++axis) {
      const value = bytes[read[output.componentType]](i * output.stride + axis * size);
      min[axis] = Math.min(min[axis], value);
      max[axis] = Math.max(max[axis], value);
    }
  }
  return { min, max };
}

function checkContent(asset, plain, compressed, report) {
  for (const { index, output } of compressed) {
    const decoded = viewBytes(plain, index);
    const stored = viewBytes(asset, index);
    if (stored && !stored.equals(decoded)) report(12, `buffer view ${index}: other bytes than its output`);
    if (!output?.isPositions) continue;
    const bounds = boundsOf(decoded, output);
    for (const accessor of asset.json.accessors.filter(({ bufferView }) => bufferView === index)) {
      for (const key of ['min', 'max']) {
        const same = accessor[key]?.every((value, axis) => Math.fround(value) === bounds[key][axis]);
        if (!same) report(8, `${key} ${accessor[key]}, expected ${bounds[key]}`);
      }
    }
  }
}

/// Faults of a packed asset, one line each. `streams` is the list that `inspect --json` gives, `plain` the asset
/// unpacked, with the same numbers for the views.
export function faultsOf(asset, streams, plain) {
  const faults = [];
  const report = (rule, what) => faults.push(`rule ${rule}: ${what}`);
  const { json } = asset;
  const compressed = json.bufferViews.flatMap((view, index) => {
    const extension = extensionOf(view);
    if (!extension) return [];
    const output = streams.find(({ bufferView }) => bufferView === extension.bufferView)?.outputs[extension.output];
    return [{ index, view, extension, output: output && layoutOf(output) }];
  });
  const byView = new Map(compressed.map((entry) => [entry.index, entry]));
  if (compressed.length === 0) report(1, 'nothing is compressed');
  if (!json.extensionsUsed?.includes(EXTENSION)) report(1, 'not in extensionsUsed');
  checkStreamViews(asset, compressed, report);
  checkCompressedViews(compressed, report);
  checkAccessors(json, byView, report);
  checkPrimitives(json, byView, report);
  checkBuffers(asset, compressed, report);
  checkContent(asset, plain, compressed, report);
  return faults;
}
