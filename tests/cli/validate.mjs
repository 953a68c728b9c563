// Checks glTF files with the Khronos validator.
//   node validate.mjs FILE…                   fails if a file has errors or warnings
//   node validate.mjs --no-worse BEFORE AFTER  fails if AFTER has more errors or warnings of any kind than BEFORE
// That the validator does not know our extension is information, not a warning, and is not counted.
import fs from 'node:fs';
import path from 'node:path';
import validator from 'gltf-validator';

async function check(file) {
  const report = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
    uri: path.basename(file),
    maxIssues: 0,
    externalResourceFunction: (uri) => fs.promises.readFile(path.join(path.dirname(file), decodeURIComponent(uri)))
      .then((data) => new Uint8Array(data)),
  });
  return report.issues.messages.filter((message) => message.severity <= 1);  // errors and warnings
}

function countByCode(messages) {
  const counts = new Map();
  for (const { code } of messages) counts.set(code, (counts.get(code) ?? 0) + 1);
  return counts;
}

const print = (file, messages) => {
  for (const { code, message, pointer } of messages.slice(0, 10)) {
    console.error(`${file}: ${pointer ?? ''}: ${code}: ${message}`);
  }
};

const files = process.argv.slice(2);
let failed = files.length === 0;
if (files[0] === '--no-worse') {
  const [before, after] = [await check(files[1]), await check(files[2])];
  const known = countByCode(before);
  for (const [code, count] of countByCode(after)) {
    if (count <= (known.get(code) ?? 0)) continue;
    failed = true;
    print(files[2], after.filter((message) => message.code === code));
  }
} else {
  for (const file of files) {
    const messages = await check(file);
    print(file, messages);
    failed ||= messages.length > 0;
    console.log(`${file}: ${messages.length === 0 ? 'valid' : `${messages.length} errors and warnings`}`);
  }
}
process.exit(failed ? 1 : 0);
