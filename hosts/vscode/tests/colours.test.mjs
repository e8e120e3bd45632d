// The colours, read by the editor's own engine: every move that olp times in the samples is coloured as one.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readdirSync, readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, extname, join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

const require = createRequire(import.meta.url);
const textmate = require("vscode-textmate");
const oniguruma = require("vscode-oniguruma");

const here = dirname(dirname(fileURLToPath(import.meta.url)));
const root = dirname(dirname(here));
const manifest = JSON.parse(readFileSync(join(here, "package.json"), "utf8"));
const python = process.env.OLP_PYTHON ?? "python3";

const wasm = readFileSync(require.resolve("vscode-oniguruma/release/onig.wasm"));
const onigLib = oniguruma.loadWASM(wasm).then(() => ({
  createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
  createOnigString: (text) => new oniguruma.OnigString(text),
}));
const registry = new textmate.Registry({
  onigLib,
  loadGrammar: async (scope) => {
    const found = manifest.contributes.grammars.find((g) => g.scopeName === scope);
    return textmate.parseRawGrammar(readFileSync(join(here, found.path), "utf8"), found.path);
  },
});

const samples = readdirSync(join(root, "samples"), { recursive: true }).map((name) =>
  join(root, "samples", name),
);

function languageOf(path) {
  return manifest.contributes.languages.find((l) => l.extensions.includes(extname(path).toLowerCase()))?.id;
}

/** What olp says of the programs; those with faults in them are left out. */
function timed(paths) {
  const command = ["-m", "olp", "time", ...paths, "--format", "json"];
  const { stdout, stderr } = spawnSync(python, command, { cwd: root, encoding: "utf8", maxBuffer: 1e9 });
  assert.ok(stdout, stderr);
  return JSON.parse(stdout);
}

function linesOf(path) {
  return readFileSync(path, "latin1").split(/\r\n|\r|\n/);
}

/** For every line its tokens: [text, scopes]. */
async function tokens(path) {
  const grammar = await registry.loadGrammar(`source.${languageOf(path)}`);
  let stack = textmate.INITIAL;
  return linesOf(path).map((line) => {
    const told = grammar.tokenizeLine(line, stack, 500);
    assert.equal(told.stoppedEarly, false, `${path}: colouring takes too long`);
    stack = told.ruleStack;
    return told.tokens.map((t) => [line.slice(t.startIndex, t.endIndex), t.scopes.join(" ")]);
  });
}

const scopesOf = (line, word) => line.find(([text]) => text.trim() === word)?.[1] ?? "";
const sample = (name) => join(root, "samples", name);

for (const { id } of manifest.contributes.languages) {
  const own = samples.filter((path) => languageOf(path) === id);
  test(`${id}: every move that olp times in the samples is coloured as a move`, async () => {
    assert.ok(own.length > 0);
    let moves = 0;
    const coloured = new Map();
    for (const { segments } of timed(own))
      for (const { file, line, kind, statement } of segments) {
        if (!["joint", "linear", "circular", "spline"].includes(kind)) continue;
        if (!coloured.has(file)) coloured.set(file, await tokens(file));
        const words = coloured.get(file)[line - 1];
        const moved = words.some(([, scopes]) => scopes.includes("support.function.motion"));
        assert.ok(moved, `${file}:${line}: ${statement}`);
        moves += 1;
      }
    assert.ok(moves > 0, "no move was looked at");
  });
}

test("comments are coloured to their end, and nothing in them", async () => {
  for (const [name, comment] of [
    ["inform/handling/HANDLING.JBI", /^'|\/\/parts/],
    ["krl/handling.src", /^\s*;/],
    ["rapid/handling.mod", /^\s*!/],
    ["tp/handling.ls", /^\s*\d+:\s*!/],
    ["urscript/handling.script", /^\s*#/],
  ]) {
    const text = linesOf(sample(name));
    const coloured = await tokens(sample(name));
    const seen = text.flatMap((line, i) => (comment.test(line) ? [coloured[i]] : []));
    assert.ok(seen.length > 1, name);
    for (const line of seen) assert.match(line.at(-1)[1], /comment\.line/, `${name}: ${line}`);
  }
});

test("words have the colour of what they do", async () => {
  const expected = [
    [
      "inform/handling/HANDLING.JBI",
      /^DOUT OT/,
      { DOUT: "support.function.instruction", "OT#": "signal", OFF: "language" },
    ],
    [
      "inform/handling/HANDLING.JBI",
      /^MOVJ C00001 VJ/,
      { MOVJ: "motion", C00001: "point", VJ: "parameter", "55.00": "numeric" },
    ],
    ["krl/handling.src", /^FOR I=1/, { FOR: "keyword.control", TO: "keyword.control", 3: "numeric" }],
    ["krl/handling.src", /^LIN XP2/, { LIN: "support.function.motion" }],
    ["krl/handling.src", /^DEF DROP/, { DEF: "storage", DROP: "entity.name.function" }],
    ["rapid/handling.mod", /SetDO do3,0; ! gripper/, { SetDO: "instruction", 0: "numeric" }],
    ["rapid/handling.mod", /PROC DROP/, { PROC: "storage", DROP: "entity.name.function" }],
    ["tp/handling.ls", /^\/PROG/, { "/PROG": "header", HANDLING: "entity.name.function" }],
    ["urscript/handling.script", /^\s*def drop/, { def: "storage", drop: "entity.name.function" }],
  ];
  for (const [name, found, scopes] of expected) {
    const at = linesOf(sample(name)).findIndex((line) => found.test(line));
    assert.ok(at >= 0, `${name} has no line ${found}`);
    const line = (await tokens(sample(name)))[at];
    for (const [word, scope] of Object.entries(scopes))
      assert.ok(scopesOf(line, word).includes(scope), `${name}:${at + 1} ${word}: ${JSON.stringify(line)}`);
  }
});
