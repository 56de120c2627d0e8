#!/usr/bin/env node
// Puts glTF files through the validator of Khronos. An error or a warning fails; what it merely
// remarks (infos, hints) is printed. Takes the validator from the folder that
// `scripts/test --importers` installs it into.
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { basename, dirname, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const SEVERITY = ["error", "warning", "info", "hint"];
const project = dirname(dirname(fileURLToPath(import.meta.url)));

function usage(code) {
  const text = "usage: scripts/validate_gltf.mjs FILE.glb|FILE.gltf ...\n"
    + "Fails where Khronos's glTF validator finds an error or a warning.";
  (code === 0 ? console.log : console.error)(text);
  process.exit(code);
}

function validator() {
  try {
    return createRequire(`${project}/.venv-node/package.json`)("gltf-validator");
  } catch (error) {
    if (error.code !== "MODULE_NOT_FOUND") throw error;
    console.error("no gltf-validator here: run scripts/test --importers once, it installs one");
    process.exit(1);
  }
}

/** Prints what the validator says about one file; whether it passes. */
async function passes(path, { validateBytes }) {
  const report = await validateBytes(new Uint8Array(await readFile(path)), {
    uri: basename(path),
    maxIssues: 100,
    externalResourceFunction: async (uri) =>
      new Uint8Array(await readFile(resolve(dirname(path), decodeURIComponent(uri)))),
  });
  const { numErrors, numWarnings, numInfos, numHints, messages } = report.issues;
  const sound = numErrors === 0 && numWarnings === 0;
  const counts = `${numErrors} errors, ${numWarnings} warnings, ${numInfos + numHints} remarks`;
  console.log(`${sound ? "ok  " : "FAIL"} ${basename(path)}: glTF validator: ${counts}`);
  for (const { severity, code, message, pointer } of messages) {
    console.log(`     ${SEVERITY[severity]} ${code} at ${pointer}: ${message}`);
  }
  return sound;
}

const files = process.argv.slice(2);
if (files.includes("--help") || files.includes("-h")) usage(0);
if (files.length === 0 || files.some((file) => file.startsWith("-"))) usage(2);
const library = validator();
let [passed, failed] = [0, 0];
for (const file of files) {
  const sound = await passes(file, library).catch((error) => {
    console.log(`FAIL ${basename(file)}: glTF validator: ${error.message ?? error}`);
    return false;
  });
  if (sound) passed += 1;
  else failed += 1;
}
console.log(`validate_gltf: ${passed} passed, ${failed} failed`);
process.exit(failed > 0 ? 1 : 0);
