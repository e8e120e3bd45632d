// The extension in VS Code, in a browser, as a user has it: what is seen is asserted, and kept as pictures.
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import {
  cpSync,
  existsSync,
  mkdirSync,
  mkdtempSync,
  readdirSync,
  readFileSync,
  rmSync,
  writeFileSync,
} from "node:fs";
import { tmpdir } from "node:os";
import { basename, join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { hosts, open, python, until } from "./code-server.mjs";
import { Editor } from "./editor.mjs";

const folder = join(hosts, "code-server", "workspace");
const pictures = join(hosts, "screenshots");
let running;
let editor;

before(async () => {
  rmSync(folder, { recursive: true, force: true });
  cpSync(resolve("../../samples/inform/palletising"), folder, { recursive: true });
  for (const name of ["krl", "rapid", "tp", "urscript"])
    cpSync(resolve(`../../samples/${name}`), join(folder, name), { recursive: true });
  mkdirSync(join(folder, "converted"));
  mkdirSync(pictures, { recursive: true });
  for (const old of readdirSync(pictures)) if (old.startsWith("vscode-")) rmSync(join(pictures, old));
  running = await open(folder);
  editor = new Editor(running.page, folder);
});
after(() => running?.stop());

const picture = (name) => running.page.screenshot({ path: join(pictures, `vscode-${name}.png`) });

/** What olp itself says first of the statements of this conversion: its words are its own. */
function receipt(file, language, robot) {
  const path = join(
    folder,
    readdirSync(folder, { recursive: true }).find((name) => basename(name) === file),
  );
  const words = ["-m", "olp", "convert", path, "--to", language, "--robot", robot, "-o"];
  const options = { cwd: resolve("../.."), encoding: "utf8" };
  const told = spawnSync(python, [...words, mkdtempSync(join(tmpdir(), "olp-"))], options);
  return told.stdout.split("\n")[1];
}

const times = new Map();
/** The seconds that olp itself says for a job of the folder. */
function timed(job) {
  if (times.has(job)) return times.get(job);
  const sample = resolve("../../samples/inform/palletising", job);
  const options = { cwd: resolve("../.."), encoding: "utf8" };
  const [{ total_s }] = JSON.parse(
    spawnSync(python, ["-m", "olp", "time", sample, "--format", "json"], options).stdout,
  );
  times.set(job, `${total_s.toFixed(3)} s`);
  return times.get(job);
}

const literal = (text) => text.replace(/[.*+?^${}()|[\]\\]/g, "\\$&");

/** A test; where it fails, what the window shows is kept, too. */
function check(name, body) {
  test(name, async () => {
    try {
      await body();
    } catch (problem) {
      await picture(`failed-${name.replace(/\W+/g, "-")}`);
      await editor.undoAll().catch(() => undefined);
      throw problem;
    }
  });
}

check("a program opens in its language, in colours", async () => {
  await editor.openFile("PICK.JBI");
  await until(async () => (await editor.status("status.editor.mode")) === "INFORM (Yaskawa)");
  const colours = await editor.colours("MOVL C00000");
  assert.ok(new Set(colours).size > 2, `one colour only: ${colours}`);
});

check("every move has its time and the running total behind it", async () => {
  await editor.sees(/MOVL C00000 V=900\.0 PL=2.*0\.[1-9]\d\d s.*Σ/);
  await editor.sees(/TIMER T=0\.15.*0\.150 s/);
});

check("the status bar has the total", async () => {
  await until(async () => /^\d+\.\d{3} s$/.test(await editor.status("olp.total")));
});

check("the total and its budget stand above the program", async () => {
  await editor.seesLens(new RegExp(`^${literal(timed("PICK.JBI"))}: motion .* yaskawa/ar2010`));
  await editor.seesLens(new RegExp(`budget PICK: ${literal(timed("PICK.JBI"))} of 3\\.5 s`));
  await picture("hints");
});

check("a hover says what a line and a point are", async () => {
  await editor.goToText("MOVL C00001 V=120.0");
  await editor.page.keyboard.press("Home");
  assert.match(await editor.hover(), /191\.9 mm/);
  await editor.goToText("C00001 V=120.0");
  await editor.page.keyboard.press("ArrowLeft");
  assert.match(await editor.hover(), /-233\.09/);
  await picture("hover");
});

check("a point leads to where it is taught, and to where it is used", async () => {
  await editor.goToText("C00001 V=120.0");
  await editor.page.keyboard.press("ArrowLeft");
  await editor.command("Go to Definition");
  await until(async () => (await editor.line()) === 11);
  await editor.command("Go to References");
  await until(async () => (await editor.line()) === 23);
});

check("the outline names what is in the program", async () => {
  await editor.command("Go to Symbol in Editor");
  const rows = running.page.locator(".quick-input-list .monaco-list-row");
  await until(async () => (await rows.allInnerTexts()).some((row) => row.includes("PICK")));
  await running.page.keyboard.press("Escape");
});

check("a misspelt word is mended by its quick fix", async () => {
  await editor.goToText("TIMER");
  await running.page.keyboard.type("TIMR");
  await running.page.locator(".squiggly-warning").first().waitFor();
  const fix = running.page.locator(".action-widget .monaco-list-row", { hasText: "Write TIMER" });
  // New findings close the menu: asked for again, as a hand would.
  await until(async () => {
    await running.page.keyboard.press("Control+.");
    return fix.waitFor({ timeout: 2000 }).then(
      () => true,
      () => false,
    );
  });
  await picture("fix");
  await fix.click();
  await editor.sees(/^TIMER T=0\.15.*0\.150 s/);
  await editor.undoAll();
});

check("words are completed", async () => {
  await editor.goToText("TIMER T=0.15");
  await running.page.keyboard.press("End");
  await running.page.keyboard.press("Enter");
  await running.page.keyboard.type("MOV");
  await running.page.keyboard.press("Control+Space");
  const offered = running.page.locator(".suggest-widget .monaco-list-row");
  await until(async () => (await offered.allInnerTexts()).some((row) => row.includes("MOVL")));
  await picture("completion");
  await running.page.keyboard.press("Escape");
  await editor.undoAll();
});

check("the side view shows segments and path", async () => {
  await editor.command("View: Toggle Primary Side Bar Visibility"); // a wider picture for docs/editors.md
  await editor.command("olp: Show Path and Times to the Side");
  const view = editor.view();
  await view.locator("#gantt").waitFor();
  await until(async () => /^PICK\.JBI: \d\.\d{3} s$/.test(await view.locator("#view-h").innerText()));
  for (const canvas of ["#gantt canvas", "#space canvas", "#speed canvas"]) {
    const { colours, width } = await editor.painted(canvas);
    assert.ok(colours > 3 && width > 200, `${canvas} shows ${colours} colours on ${width} points`);
  }
  assert.equal(await view.locator("header").isVisible(), false);
});

check("the view follows the cursor", async () => {
  await editor.goToText("MOVL C00001 V=120.0");
  await until(async () => (await editor.facts()).line === "23");
  assert.match((await editor.facts()).statement, /^MOVL C00001/);
  await picture("view");
});

check("the cursor follows the view", async () => {
  await editor.clickSegment(0.05);
  await until(async () => (await editor.facts()).statement?.startsWith("MOVL C00000"));
  const { line } = await editor.facts();
  await until(async () => (await editor.line()) === Number(line));
});

check("the view keeps how it is turned when the text changes", async () => {
  const { x, width, y, height } = await editor.view().locator("#space").boundingBox();
  await running.page.mouse.move(x + width / 2, y + height / 2);
  await running.page.mouse.down();
  await running.page.mouse.move(x + width / 2 + 90, y + height / 2 + 40, { steps: 5 });
  await running.page.mouse.up();
  const turned = await editor.picture("#space canvas");
  const before = await editor.view().locator("#view-h").innerText();
  await editor.goToText("TIMER T=0.15");
  await editor.typeAtEnd("9");
  await until(async () => (await editor.view().locator("#view-h").innerText()) !== before);
  await editor.sees(/TIMER T=0\.159/);
  await editor.goToText("MOVL C00000 V");
  await until(async () => (await editor.facts()).statement?.startsWith("MOVL C00000"));
  assert.equal(await editor.picture("#space canvas"), turned);
});

check("a mistake is underlined as it is typed, and the view waits", async () => {
  await editor.goToText("DOUT OT#(7)");
  await editor.typeAtEnd(" NONSENSE");
  await running.page.locator(".squiggly-error").first().waitFor();
  await editor.command("View: Toggle Problems");
  await editor.seesProblem(/NONSENSE/);
  await editor.command("View: Toggle Problems");
  await editor.undoAll();
  await running.page.locator(".squiggly-error").waitFor({ state: "detached" });
});

check("the side view takes the editor's theme", async () => {
  const paper = () =>
    editor
      .view()
      .locator("body")
      .evaluate((body) => getComputedStyle(body).backgroundColor);
  const dark = await paper();
  editor.set({ "workbench.colorTheme": "Default Light Modern" });
  await until(async () => (await paper()) !== dark);
  assert.equal(await paper(), "rgb(255, 255, 255)");
  await picture("light");
  editor.set({});
  await until(async () => (await paper()) === dark);
});

check("settings reach the server: half the speed takes longer", async () => {
  const before = parseFloat(await editor.status("olp.total"));
  editor.set({ "olp.override": 50 });
  await until(async () => parseFloat(await editor.status("olp.total")) > before * 1.3);
  await editor.sees(/MOVL C00001 V=120\.0.*3\.2\d\d s/);
  editor.set({});
  await until(async () => parseFloat(await editor.status("olp.total")) === before);
});

check("a line of a called program is chosen from its caller's view", async () => {
  await editor.openFile("MAIN.JBI");
  await until(async () =>
    /^MAIN\.JBI: 1\d\d\.\d{3} s$/.test(await editor.view().locator("#view-h").textContent()),
  );
  await editor.view().locator("#search").fill("MOVL C00001 V=120.0");
  await editor.view().locator("#segments tbody tr").first().click();
  await editor.seesTab("PICK.JBI");
  assert.match((await editor.facts()).line, /of PICK\.JBI$/);
  await until(async () => (await editor.line()) === 23);
  await editor.seesLens(new RegExp(`^${literal(timed("PICK.JBI"))}: motion`));
  await picture("called");
});

check("olp's own table stands beside the program on request", async () => {
  await editor.openFile("PICK.JBI");
  await editor.command("olp: Time This Program");
  await editor.sees(new RegExp(`total ${literal(timed("PICK.JBI"))}`));
});

check("the other languages open in theirs, with times", async () => {
  editor.set({ "olp.robot": "yaskawa/gp25" });
  for (const [file, language, statement, hint] of [
    ["handling.src", "KRL (KUKA)", "LIN XP2", /LIN XP2.*\d\.\d{3} s.*Σ/],
    ["handling.mod", "RAPID (ABB)", "MoveL pPart", /MoveL pPart,.*\d\.\d{3} s.*Σ/],
    ["handling.ls", "TP (FANUC)", "L P[", /L P\[.*\d\.\d{3} s.*Σ/],
    ["handling.script", "URScript (Universal Robots)", "movel(", /movel\(.*\d\.\d{3} s.*Σ/],
  ]) {
    await editor.openFile(file);
    await until(async () => (await editor.status("status.editor.mode")) === language);
    await editor.goToText(statement);
    await editor.sees(hint);
    await picture(file);
  }
  editor.set({});
});

check("a report is written where the user says", async () => {
  await editor.openFile("PICK.JBI");
  await editor.command("olp: Write a Report…");
  await editor.answer(join(folder, "out.html"));
  await until(() => existsSync(join(folder, "out.html")));
  assert.match(readFileSync(join(folder, "out.html"), "utf8"), /Cycle time of/);
});

check("a program is converted, and its receipt stands beside", async () => {
  await editor.openFile("handling.script");
  await editor.command("olp: Convert to Another Robot");
  await editor.choose("krl", "krl");
  await editor.answer("yaskawa/gp25");
  await editor.answer(`${join(folder, "converted")}/`);
  await until(() => existsSync(join(folder, "converted", "handling.src")));
  await editor.sees(new RegExp(literal(receipt("handling.script", "krl", "yaskawa/gp25"))));
});

check("what the other language cannot say is asked about first", async () => {
  await editor.openFile("PICK.JBI");
  await editor.command("olp: Convert to Another Robot");
  await editor.choose("krl", "krl");
  await editor.answer("yaskawa/ar2010");
  await editor.answer(`${join(folder, "converted")}/`);
  await editor.press(/krl cannot say [1-9]\d* of the statements/, "Write Them as Comments");
  await until(() => existsSync(join(folder, "converted", "PICK.src")));
});

check("a file that changes on the disk changes the times of its callers", async () => {
  await editor.openFile("MAIN.JBI");
  await until(async () => (await editor.status("olp.total")) === timed("MAIN.JBI"));
  const place = join(folder, "PLACE.JBI");
  const job = readFileSync(place, "latin1");
  writeFileSync(place, job.replaceAll("V=120.0", "V=60.0").replaceAll("T=0.", "T=1."), "latin1");
  await until(async () => parseFloat(await editor.status("olp.total")) > parseFloat(timed("MAIN.JBI")) + 4);
  writeFileSync(place, job, "latin1");
  await until(async () => (await editor.status("olp.total")) === timed("MAIN.JBI"));
});

check("a server that cannot start is told in its own words", async () => {
  const said = "error[C012]: the language server needs the library pygls";
  editor.set({ "olp.command": ["/bin/sh", "-c", `echo '${said}' >&2; exit 2`] });
  await editor.told(/has ended: error\[C012\]: the language server needs the library pygls/);
});

check("where olp is not installed, it is said how to", async () => {
  editor.set({ "olp.command": ["/nowhere/olp"] });
  await editor.told(/not found as “\/nowhere\/olp”. Install it with: pip install "olp\[lsp\]"/);
  const errors = running.page.locator(".notification-list-item .codicon-error");
  assert.equal(await errors.count(), 2); // and the one before
  await picture("missing");
  editor.set({});
  await until(async () => (await editor.status("olp.total")) === timed("MAIN.JBI"));
});
