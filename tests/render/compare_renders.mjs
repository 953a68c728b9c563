// Packs and unpacks assets, renders the originals and what came back with three.js in headless Chromium and compares
// the pictures, which stay in the folder of the npm packages.
//
//   node compare_renders.mjs --program FILE --packages DIR [--corpus DIR] [--chromium FILE]
//
// --packages: folder in which npm installed three. Exits with 77 where three, Chromium or the corpus is absent, with 1
// where pictures differ, or where an asset packed far too coarsely would pass as equal too.
import { spawn, spawnSync } from 'node:child_process';
import fs from 'node:fs';
import http from 'node:http';
import os from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const here = path.dirname(fileURLToPath(import.meta.url));
const root = path.join(here, '../..');
const options = {
  corpus: path.join(root, '../shared/corpus'),
  program: path.join(root, 'build/release/src/cli/gltf-tsc'),
  packages: path.join(root, 'build/release/render'),
  chromium: 'chromium',
};
const argv = process.argv.slice(2);
for (let i = 0; i + 1 < argv.length; i += 2) {
  const name = argv[i].replace(/^--/, '');
  if (!(name in options)) throw new Error(`unknown option ${argv[i]}`);
  options[name] = name === 'chromium' ? argv[i + 1] : path.resolve(argv[i + 1]);
}

/// Textures and one primitive; a skin in motion; several primitives with common borders.
const assets = [
  { name: 'Duck', path: 'gltf/meshlab__Duck/Duck.gltf' },
  { name: 'Fox', path: 'gltf/bevy__Fox/Fox.glb' },
  { name: 'car', path: 'gltf/Online3DViewer__car/car.glb' },
];
// The difference that 14 bits make: of 255 levels, on average over the picture; and the share of pixels off by more
// than 24 levels, which edges that move across the middle of a pixel cause.
const maxMean = 0.1;
const maxVisible = 0.002;
const minDrawn = 0.03;
const coarseBits = 6;  // must not pass
const timeoutSeconds = 180;

const skip = (reason) => {
  console.log(`SKIPPED: nothing was rendered: ${reason}`);
  process.exit(77);
};
const three = path.join(options.packages, 'node_modules/three');
if (!fs.existsSync(three)) skip(`no three.js: npm install --prefix ${options.packages}`);
if (spawnSync(options.chromium, ['--version']).status !== 0) skip(`no ${options.chromium} (Debian package chromium)`);
for (const asset of assets) {
  if (!fs.existsSync(path.join(options.corpus, asset.path))) skip(`no ${asset.path} in ${options.corpus}`);
}

const scratch = fs.mkdtempSync(path.join(os.tmpdir(), 'tsc-render-'));
process.on('exit', () => fs.rmSync(scratch, { recursive: true, force: true }));
const pictures = path.join(options.packages, 'pictures');
fs.mkdirSync(pictures, { recursive: true });

function runProgram(...args) {
  const result = spawnSync(options.program, args, { encoding: 'utf8' });
  if (result.status !== 0) throw new Error(`gltf-tsc ${args.join(' ')}: ${result.stderr}`);
}

/// Packs and unpacks; gives the unpacked file's URL.
function roundTrip(asset, kind, ...packOptions) {
  const input = path.join(options.corpus, asset.path);
  const folder = path.join(scratch, asset.name, kind);
  fs.mkdirSync(folder, { recursive: true });
  const extension = path.extname(asset.path);
  runProgram('pack', input, '-o', path.join(folder, `packed${extension}`), ...packOptions);
  runProgram('unpack', path.join(folder, `packed${extension}`), '-o', path.join(folder, `plain${extension}`));
  return `/scratch/${asset.name}/${kind}/plain${extension}`;
}

const jobs = assets.map((asset) => ({
  name: asset.name,
  original: `/corpus/${asset.path}`,
  others: {
    unpacked: roundTrip(asset, 'unpacked'),
    coarse: roundTrip(asset, 'coarse', '--position-bits', String(coarseBits)),
  },
}));

// ---------------------------------------------------------------------------------------------------------- Server

const folders = { three, corpus: options.corpus, scratch };
const types = { '.js': 'text/javascript', '.html': 'text/html', '.png': 'image/png', '.gltf': 'model/gltf+json' };

/// The file behind a path of the page, or nothing: only files inside the folders above.
function fileOf(url) {
  if (url === '/') return path.join(here, 'page.html');
  const [, name, ...rest] = decodeURIComponent(url).split('/');
  const folder = folders[name];
  const file = folder && path.join(folder, ...rest);
  return file?.startsWith(folder + path.sep) && fs.existsSync(file) ? file : null;
}

let finish;
const finished = new Promise((resolve) => { finish = resolve; });
const server = http.createServer((request, response) => {
  if (request.method === 'POST') {
    const parts = [];
    request.on('data', (part) => parts.push(part));
    request.on('end', () => {
      const body = Buffer.concat(parts);
      if (request.url === '/done') finish(JSON.parse(body.toString()));
      const picture = request.url.match(/^\/picture\/([\w-]+)$/);
      if (picture) fs.writeFileSync(path.join(pictures, `${picture[1]}.png`), body);
      response.end();
    });
    return;
  }
  if (request.url === '/jobs') {
    response.end(JSON.stringify(jobs));
    return;
  }
  const file = fileOf(request.url);
  if (!file) response.writeHead(404);
  else response.writeHead(200, { 'Content-Type': types[path.extname(file)] ?? 'application/octet-stream' });
  response.end(file ? fs.readFileSync(file) : '');
});
await new Promise((resolve) => server.listen(0, '127.0.0.1', resolve));

// --------------------------------------------------------------------------------------------------------- Browser

const browser = spawn(options.chromium, [
  '--headless=new', '--no-sandbox', '--disable-gpu-sandbox', '--use-gl=angle', '--use-angle=swiftshader',
  '--enable-unsafe-swiftshader', '--disable-dev-shm-usage', '--no-first-run', '--disable-background-networking',
  '--disable-component-update', '--disable-sync', `--user-data-dir=${path.join(scratch, 'profile')}`,
  `http://127.0.0.1:${server.address().port}/`,
], { stdio: ['ignore', 'ignore', 'pipe'], detached: true });
let log = '';
browser.stderr.on('data', (text) => { log = (log + text).slice(-4000); });
browser.on('exit', (code) => finish({ failed: `Chromium ended with ${code}: ${log}` }));
setTimeout(() => finish({ failed: `no picture within ${timeoutSeconds} s: ${log}` }), timeoutSeconds * 1000).unref();

const { results, failed } = await finished;
browser.removeAllListeners('exit');
const closed = new Promise((resolve) => browser.once('exit', resolve));
if (browser.exitCode === null) {
  process.kill(-browser.pid);  // its own process group: all of its processes and nothing else
  await closed;
}
server.closeAllConnections();
server.close();
if (failed) throw new Error(failed);

let wrong = 0;
for (const { name, kind, mean, visible, drawn } of results) {
  const equal = mean <= maxMean && visible <= maxVisible;
  const shows = drawn >= minDrawn;
  const right = shows && equal === (kind === 'unpacked');
  wrong += right ? 0 : 1;
  console.log(`${name}, ${kind}: mean difference ${mean.toFixed(4)} of 255, ${(100 * visible).toFixed(3)}% of the ` +
              `pixels visibly different, ${(100 * drawn).toFixed(1)}% drawn${right ? '' : ': WRONG'}`);
}
console.log(`pictures: ${pictures}`);
process.exit(wrong > 0 ? 1 : 0);
