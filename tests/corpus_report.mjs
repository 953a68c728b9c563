// Packs and unpacks every asset of a corpus with the built program and tells what became of each: the tables of the
// README, and proof that nothing is lost in silence and that nothing cracks.
//
//   node corpus_report.mjs [--corpus DIR] [--program FILE] [--validator DIR] [--loader FILE] [--cracks FILE]
//                          [--sanitized FILE] [--short] [--json FILE] [--readme FILE]
//
// --validator: folder in which npm installed gltf-validator. --loader: a program that loads its arguments with
// tinygltf and prints `FILE: reason` for each that fails. --cracks: the program that counts cracked edges, here and
// after Draco. --sanitized: the same program as --program, built with sanitizers; each asset goes through both.
// --short: every eighth file, for continuous integration. --readme: writes the tables into this file, between its
// marks.
//
// Exits with 77 where the corpus or the program is absent, with 1 where anything is wrong: a crash, a file that takes
// over 10 s of processor time or 1 GiB, an accepted asset that does not come back, a new error or warning of the
// validator, an unpacked file that tinygltf or assimp cannot load though it could load the original, a refusal without
// a place, a cracked edge, a finding of a sanitizer. Processor time, so that a busy machine fails no file; memory is the
// largest resident set, of the plain program, for a sanitized one takes several times as much by its nature.
import { spawnSync } from 'node:child_process';
import fs from 'node:fs';
import { createRequire } from 'node:module';
import os from 'node:os';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

const root = path.dirname(path.dirname(fileURLToPath(import.meta.url)));
const options = {
  corpus: path.join(root, '../shared/corpus'),
  program: path.join(root, 'build/release/src/cli/gltf-tsc'),
  validator: path.join(root, 'build/release/validator'),
  loader: path.join(root, 'build/release/tests/gltf/tsc_load_with_tinygltf'),
  cracks: path.join(root, 'build/release/tests/gltf/tsc_count_cracked_edges'),
  sanitized: '',
  json: '',
  readme: '',
};
const argv = process.argv.slice(2);
const short = argv.includes('--short');
for (let i = 0; i < argv.length; ++i) {
  const name = argv[i].replace(/^--/, '');
  if (name in options) options[name] = path.resolve(argv[++i]);
}

const maxSeconds = 10;
const maxKilobytes = 1 << 20;
const skip = (reason) => {
  console.log(`skipped: ${reason}`);
  process.exit(77);
};
if (!fs.existsSync(path.join(options.corpus, 'manifest.csv'))) skip(`no corpus at ${options.corpus}`);
for (const program of [options.program, options.sanitized].filter(Boolean)) {
  if (!fs.existsSync(program)) skip(`no program at ${program}`);
}

let validator = null;
try {
  validator = createRequire(path.join(options.validator, 'package.json'))('gltf-validator');
} catch {
  console.log(`note: no gltf-validator in ${options.validator}; nothing is validated`);
}
const has = (program) => spawnSync('sh', ['-c', `command -v ${program}`]).status === 0;
const hasAssimp = has('assimp');
const hasTime = fs.existsSync('/usr/bin/time');
const hasLoader = fs.existsSync(options.loader);
const hasCracks = fs.existsSync(options.cracks);
if (!hasAssimp) console.log('note: no assimp; its loads are not tried');
if (!hasTime) console.log('note: no /usr/bin/time; memory is not measured');
if (!hasLoader) console.log(`note: no ${options.loader}; loads with tinygltf are not tried`);
if (!hasCracks) console.log(`note: no ${options.cracks}; cracked edges are not counted`);

/// Rows of manifest.csv as objects; quoted columns may hold commas.
function readManifest() {
  const split = (line) => [...line.matchAll(/("([^"]*)"|[^,]*)(,|$)/g)].map((m) => m[2] ?? m[1]);
  const lines = fs.readFileSync(path.join(options.corpus, 'manifest.csv'), 'utf8').split(/\r?\n/).filter(Boolean);
  const header = split(lines[0]);
  return lines.slice(1).map((line) => {
    const columns = split(line);
    return Object.fromEntries(header.map((name, i) => [name, columns[i]]));
  });
}

/// Runs a program under the limits; `seconds` of processor time, so that it is killed for what it does and not for how
/// busy the machine is.
function runLimited(program, args) {
  const timeFile = path.join(scratch, 'time');
  const measured = hasTime ? ['/usr/bin/time', '-q', '-o', timeFile, '-f', '%U %S %M'] : [];
  const command = [...measured, 'sh', '-c', `ulimit -t ${maxSeconds + 5}; exec "$0" "$@"`, program, ...args];
  const result = spawnSync(command[0], command.slice(1), { timeout: maxSeconds * 20000, encoding: 'utf8' });
  let seconds = 0;
  let kilobytes = 0;
  if (hasTime && fs.existsSync(timeFile)) {
    const [user, system, peak] = fs.readFileSync(timeFile, 'utf8').trim().split('\n').pop().split(' ').map(Number);
    seconds = user + system;
    kilobytes = peak;
    fs.rmSync(timeFile);
  }
  const problems = [];
  // GNU time gives 128 + signal, as a shell does.
  if (result.status === null || result.status > 5) problems.push(`crashed (${result.signal ?? result.status})`);
  if (seconds > maxSeconds) problems.push(`took ${seconds} s`);
  return { code: result.status, message: result.stderr?.trim() ?? '', seconds, kilobytes, problems };
}

/// Runs the program; what it took goes into `costs`.
const costs = { seconds: 0, secondsOf: '', kilobytes: 0, kilobytesOf: '', sanitizedSeconds: 0, sanitizedSecondsOf: '' };
function run(args, file) {
  const result = runLimited(options.program, args);
  const { seconds, kilobytes } = result;
  if (seconds > costs.seconds) Object.assign(costs, { seconds, secondsOf: file });
  if (kilobytes > costs.kilobytes) Object.assign(costs, { kilobytes, kilobytesOf: file });
  if (kilobytes > maxKilobytes) result.problems.push(`took ${kilobytes} KiB`);
  return result;
}

/// The same with the sanitized program, which must come to the same end as the plain one did with exit code `expected`.
function sanitizedProblems(args, file, expected) {
  if (!options.sanitized) return [];
  const { code, message, seconds, problems } = runLimited(options.sanitized, args);
  if (seconds > costs.sanitizedSeconds) Object.assign(costs, { sanitizedSeconds: seconds, sanitizedSecondsOf: file });
  const finding = message.split('\n').find((line) => /runtime error|Sanitizer/.test(line));
  if (finding) problems.push(finding);
  if (code !== expected && problems.length === 0) problems.push(`exit code ${code}, without sanitizers ${expected}`);
  return problems.map((problem) => `sanitized ${args[0]}: ${problem}`);
}

async function issuesOf(file) {
  const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
    uri: path.basename(file),
    maxIssues: 0,
    externalResourceFunction: async (uri) =>
      new Uint8Array(await fs.promises.readFile(path.join(path.dirname(file), decodeURIComponent(uri)))),
  });
  const counts = new Map();
  const examples = new Map();
  for (const { code, severity, message, pointer } of report.issues.messages) {
    if (severity > 1) continue;
    counts.set(code, (counts.get(code) ?? 0) + 1);
    examples.set(code, `${pointer ?? ''} ${message}`);
  }
  return { counts, examples };
}

async function newIssues(entry, before, after) {
  if (!validator) return [];
  const known = await issuesOf(before).catch(() => null);
  if (!known) return [];
  const found = await issuesOf(after)
    .catch((error) => ({ counts: new Map([[String(error), 1]]), examples: new Map() }));
  // In compressed input the validator does not see the data, so that faults of its values come to light only now.
  const hidden = /draco|meshopt/.test(entry.extensions) ? ['ACCESSOR_VECTOR3_NON_UNIT', 'ACCESSOR_NON_UNIT'] : [];
  return [...found.counts].filter(([code, count]) => count > (known.counts.get(code) ?? 0) && !hidden.includes(code))
    .map(([code, count]) => `${code} x${count} (before: ${known.counts.get(code) ?? 0}): ${found.examples.get(code)}`);
}

const loads = (command, args) => spawnSync(command, args, { encoding: 'utf8', timeout: 60000 });
function loadProblems(original, plain) {
  const problems = [];
  const tries = [];
  if (hasAssimp) tries.push(['assimp', (file) => loads('assimp', ['info', file])]);
  if (hasLoader) tries.push(['tinygltf', (file) => loads(options.loader, [file])]);
  for (const [name, load] of tries) {
    const result = load(plain);
    if (result.status === 0) continue;
    // No worse than before: some assets defeat a reader as their authors made them.
    if (load(original).status !== 0) continue;
    problems.push(`${name} cannot load the unpacked file: ${(result.stdout + result.stderr).trim().split('\n').pop()}`);
  }
  return problems;
}

const scratch = fs.mkdtempSync(path.join(os.tmpdir(), 'tsc-corpus-'));
process.on('exit', () => fs.rmSync(scratch, { recursive: true, force: true }));

/// Edges that primitives share, and how many of them crack: here, and in Draco at 14 and 11 bits.
function cracksOf(input) {
  if (!hasCracks) return null;
  const result = spawnSync(options.cracks, [input], { timeout: 120000, encoding: 'utf8' });
  if (result.status !== 0) return { failed: `crashed (${result.signal ?? result.status})` };
  return JSON.parse(result.stdout);
}

/// What pack says of an asset: from a second run, for its report measures distortion, which is not what is timed here.
function reportOf(input, folder, extension) {
  const file = path.join(folder, 'report.json');
  const args = ['pack', input, '--force', '-o', path.join(folder, `again${extension}`), '--report', file];
  const result = spawnSync(options.program, args, { timeout: 120000, encoding: 'utf8' });
  if (!fs.existsSync(file)) throw new Error(`${input}: no report: ${result.stderr}`);
  return JSON.parse(fs.readFileSync(file, 'utf8'));
}

/// What became of one asset: { fate: one of `fates`, reasons, problems }.
async function process1(entry) {
  const input = path.join(options.corpus, entry.path);
  const folder = fs.mkdtempSync(path.join(scratch, 'asset-'));
  const extension = path.extname(entry.path) === '.gltf' ? '.gltf' : '.glb';
  const packed = path.join(folder, `packed${extension}`);
  const plain = path.join(folder, `plain${extension}`);
  try {
    const pack = run(['pack', input, '-o', packed], entry.path);
    const sanitized = (verb, from, code) =>
      sanitizedProblems([verb, from, '-o', path.join(folder, `sanitized-${verb}${extension}`)], entry.path, code);
    if (pack.code !== 0) {
      const problems = [...pack.problems, ...sanitized('pack', input, pack.code)];
      const message = pack.message.split('\n').pop();
      if (!/^gltf-tsc: .+: .+/.test(message)) problems.push(`a refusal without a place: ${message}`);
      if (fs.readdirSync(folder).length > 0) problems.push('a refusal left files behind');
      return { fate: 'refused', reasons: [message.replace(`gltf-tsc: ${input}: `, '')], problems };
    }
    const report = reportOf(input, folder, extension);
    const reasons = [...new Set(report.kept.map((kept) => kept.reason))];
    const untouched = reasons.length > 0 ? 'kept' : 'empty';
    const fate = report.streams.length === 0 ? untouched : reasons.length > 0 ? 'partly' : 'packed';
    const unpack = run(['unpack', packed, '-o', plain], entry.path);
    const problems = [...pack.problems, ...unpack.problems, ...sanitized('pack', input, 0),
                      ...sanitized('unpack', packed, unpack.code)];
    if (unpack.code !== 0) problems.push(`unpack: ${unpack.message}`);
    problems.push(...(await newIssues(entry, input, packed)).map((issue) => `packed: ${issue}`));
    if (unpack.code === 0) {
      problems.push(...(await newIssues(entry, input, plain)).map((issue) => `unpacked: ${issue}`));
      problems.push(...loadProblems(input, plain));
    }
    for (const stream of report.streams) {
      if (!(stream.maxError <= stream.guaranteedError)) problems.push(`${stream.label}: error above the bound`);
    }
    const cracks = cracksOf(input);
    if (cracks?.failed && report.streams.length > 0) problems.push(`counting cracked edges: ${cracks.failed}`);
    if (cracks?.after !== cracks?.before) problems.push(`${cracks.after} cracked edges, ${cracks.before} before`);
    const triangles = report.streams.reduce((sum, stream) => sum + stream.triangles, 0);
    return { fate, reasons, problems, cracks, triangles };
  } finally {
    fs.rmSync(folder, { recursive: true, force: true });
  }
}

const rows = readManifest().filter((entry) => entry.class === 'gltf' || entry.class === 'bad')
  .filter((_, i) => !short || i % 8 === 0);
const results = [];
for (const entry of rows) results.push({ entry, ...(await process1(entry)) });

const verdicts = ['valid', 'tolerable', 'invalid', 'unreadable'];
const fates = {
  packed: 'packed',
  partly: 'packed in part, said why',
  empty: 'nothing to pack',
  kept: 'kept, said why',
  refused: 'refused, said why',
};

/// What became of assets, by what the validator says of them. Fates that none met have no column.
function fateTable() {
  const met = Object.keys(fates).filter((fate) => results.some((result) => result.fate === fate));
  const lines = [`| the validator says | tried | ${met.map((fate) => fates[fate]).join(' | ')} |`,
                 `|---|--:|${met.map(() => '--:|').join('')}`];
  for (const verdict of verdicts) {
    const group = results.filter(({ entry }) => entry.expect === verdict);
    const counts = met.map((fate) => group.filter((result) => result.fate === fate).length);
    lines.push(`| ${verdict} | ${group.length} | ${counts.join(' | ')} |`);
  }
  return lines.join('\n');
}

function crackTable() {
  const counted = results.map(({ cracks }) => cracks).filter((cracks) => cracks?.shared > 0);
  const row = (name, count) => {
    const cracked = counted.map(count);
    return `| ${name} | ${cracked.reduce((a, b) => a + b, 0)} | ${cracked.filter(Boolean).length} |`;
  };
  return [`| of ${counted.reduce((sum, { shared }) => sum + shared, 0)} edges that primitives share, in ` +
          `${counted.length} assets | cracked edges | assets |`, '|---|--:|--:|', row('as they were', (c) => c.before),
          row('packed and unpacked', (c) => c.after),
          row('Draco, each primitive by itself, 14 bits', (c) => c.draco14.cracked),
          row('Draco, each primitive by itself, 11 bits', (c) => c.draco11.cracked)].join('\n');
}

const tables = hasCracks ? `${fateTable()}\n\n${crackTable()}` : fateTable();
console.log(`\n${results.length} assets\n\n${tables}`);
if (options.readme) {
  const marks = /(<!-- corpus_report\.mjs -->\n)[\s\S]*?(<!-- end -->)/;
  const readme = fs.readFileSync(options.readme, 'utf8');
  if (!marks.test(readme)) throw new Error(`${options.readme}: no marks <!-- corpus_report.mjs --> and <!-- end -->`);
  fs.writeFileSync(options.readme, readme.replace(marks, `$1\n${tables}\n\n$2`));
}
const megabytes = (costs.kilobytes / 1024).toFixed(0);
console.log(`\nMost time: ${costs.seconds.toFixed(2)} s (${costs.secondsOf}).`);
console.log(`Most memory: ${megabytes} MiB (${costs.kilobytesOf}).`);
if (options.sanitized) {
  console.log(`Most time with sanitizers: ${costs.sanitizedSeconds.toFixed(2)} s (${costs.sanitizedSecondsOf}).`);
}

for (const fate of ['kept', 'partly', 'refused']) {
  console.log(`\n${fate}:`);
  for (const { entry, reasons } of results.filter((result) => result.fate === fate)) {
    console.log(`  ${entry.path} (${entry.expect}): ${reasons.join('; ')}`);
  }
}
const wrong = results.filter(({ problems }) => problems.length > 0);
console.log(`\nproblems: ${wrong.length}`);
for (const { entry, problems } of wrong) {
  for (const problem of problems) console.log(`  ${entry.path} (${entry.expect}): ${problem}`);
}
if (options.json) {
  fs.writeFileSync(options.json, JSON.stringify(results.map(({ entry, ...rest }) =>
    ({ path: entry.path, expect: entry.expect, ...rest })), null, 1));
}
process.exit(wrong.length > 0 ? 1 : 0);
