// Packs every sample in every form and checks the extension's JSON: against extension-spec/schema, and against the
// rules for assets of extension-spec/README.md. The schema must also refuse what is wrong.
//   node check_samples.mjs PROGRAM SAMPLES SCHEMAS        exit code 77: the npm modules are not installed
import { execFileSync } from 'node:child_process';
import fs from 'node:fs';
import os from 'node:os';
import path from 'node:path';

import { readAsset } from './asset.mjs';
import { faultsOf } from './asset_rules.mjs';

const EXTENSION = 'EXT_mesh_tangentspace_compression';
const [program, samples, schemas] = process.argv.slice(2);

const Ajv = await import('ajv-draft-04').then((module) => module.default.default ?? module.default, () => null);
if (!Ajv) {
  console.error('ajv-draft-04 is not installed: npm install --prefix <build>/validator');
  process.exit(77);
}

const failures = [];
const expect = (holds, what) => { if (!holds) failures.push(what); };

/// Validators by the kind of property that the extension stands on. The two schemas of glTF 2.0 that ours refer to are
/// stated here as far as they matter.
function compileSchemas() {
  const ajv = new Ajv({ strict: true, strictTypes: false });
  ajv.addSchema({ type: 'object', properties: { extensions: { type: 'object' } } }, 'glTFProperty.schema.json');
  ajv.addSchema({ type: 'integer', minimum: 0 }, 'glTFid.schema.json');
  return Object.fromEntries(fs.readdirSync(schemas).map((file) => {
    const schema = JSON.parse(fs.readFileSync(path.join(schemas, file)));
    delete schema.$schema;  // draft-04, which this Ajv speaks; it knows the address only with a trailing '#'
    expect(ajv.validateSchema(schema), `${file} is no draft-04 schema`);
    return [file.split('.')[0], ajv.compile(schema)];
  }));
}

/// Every object of the extension in a document, as [kind of property, object].
function extensionObjects(json) {
  const found = [];
  const visit = (holders, kind) => (holders ?? []).forEach((holder) => {
    const object = holder.extensions?.[EXTENSION];
    if (object) found.push([kind, object]);
  });
  visit([json], 'glTF');
  visit(json.buffers, 'buffer');
  visit(json.bufferViews, 'bufferView');
  visit(json.meshes, 'mesh');
  visit(json.meshes?.flatMap((mesh) => mesh.primitives), 'primitive');
  visit(json.accessors, 'accessor');
  return found;
}

function checkSample(validators, sample, name, options) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), 'gltf-tsc-schema-'));
  const run = (...words) => execFileSync(program, words, { cwd: folder, stdio: ['ignore', 'pipe', 'pipe'] });
  try {
    run('pack', sample, '-o', name, '--quiet', ...options);
    const { streams } = JSON.parse(run('inspect', '--json', name));
    run('unpack', name, '-o', 'plain.gltf', '--quiet');
    const packed = readAsset(path.join(folder, name));
    const plain = readAsset(path.join(folder, 'plain.gltf'));
    const label = `${path.basename(sample)} as ${[name, ...options].join(' ')}`;
    const objects = extensionObjects(packed.json);
    for (const [kind, object] of objects) {
      const validate = validators[kind];
      expect(validate, `${label}: no schema for the extension on ${kind}`);
      if (validate) expect(validate(object), `${label}: ${JSON.stringify(object)}: ${JSON.stringify(validate.errors)}`);
    }
    for (const fault of faultsOf(packed, streams, plain)) failures.push(`${label}: ${fault}`);
    expect(extensionObjects(plain.json).length === 0, `${label}: unpack left the extension behind`);
    return objects.length;
  } finally {
    fs.rmSync(folder, { recursive: true });
  }
}

function checkRefusals(validators) {
  const refused = {
    bufferView: [{}, { bufferView: 1 }, { output: 0 }, { bufferView: -1, output: 0 }, { bufferView: 1, output: -1 },
      { bufferView: 1.5, output: 0 }, { bufferView: '1', output: 0 }, { bufferView: 1, output: 0, order: 2 },
      { bufferView: 1, output: 0, order: {} }, { bufferView: 1, output: 0, order: { bufferView: -1 } }, []],
    buffer: [{ fallback: 1 }, { fallback: 'true' }, { extensions: 1 }, []],
  };
  for (const [kind, objects] of Object.entries(refused)) {
    for (const object of objects) expect(!validators[kind](object), `${kind}: accepts ${JSON.stringify(object)}`);
  }
  for (const more of [{}, { extras: [1] }, { order: { bufferView: 8 } }]) {
    expect(validators.bufferView({ bufferView: 7, output: 0, ...more }), `bufferView: refuses ${JSON.stringify(more)}`);
  }
  expect(validators.buffer({}), 'buffer: refuses what is right');
}

const validators = compileSchemas();
checkRefusals(validators);
let checked = 0;
const forms = [[], ['--fallback']];
if (execFileSync(program, ['pack', '--help']).includes('--keep-order')) {
  forms.push(['--keep-order'], ['--keep-order', '--fallback']);
}
for (const file of fs.readdirSync(samples).filter((name) => /\.(gltf|glb)$/.test(name))) {
  for (const name of ['packed.gltf', 'packed.glb']) {
    for (const options of forms) checked += checkSample(validators, path.join(samples, file), name, options);
  }
}
expect(checked > 0, 'nothing was checked');
for (const failure of failures) console.error(failure);
console.log(`${checked} extension objects checked, ${failures.length} failures`);
process.exit(failures.length === 0 ? 0 : 1);
