/** VS Code in a browser with the packed extension: a server of its own, an empty profile, nothing of the network. */
import { execFileSync, spawn } from "node:child_process";
import { mkdirSync, rmSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { join, resolve } from "node:path";
import { chromium } from "playwright-core";

export const hosts = process.env.OLP_HOSTS ?? resolve("../../.hosts");
export const python = process.env.OLP_PYTHON ?? "python3";
const installed = join(hosts, "code-server", "node_modules");
const node = join(installed, "node", "bin", "node");
const entry = join(installed, "code-server", "out", "node", "entry.js");

const home = join(hosts, "code-server", "profile");

const QUIET = [
  "--headless",
  "--no-sandbox",
  "--use-angle=swiftshader",
  "--enable-unsafe-swiftshader",
  "--disable-quic",
  "--no-first-run",
  "--disable-background-networking",
  "--disable-component-update",
  "--disable-sync",
  "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
];

const SETTINGS = {
  "olp.command": [python, "-m", "olp"],
  "telemetry.telemetryLevel": "off",
  "update.mode": "none",
  "extensions.autoUpdate": false,
  "extensions.autoCheckUpdates": false,
  "security.workspace.trust.enabled": false,
  "workbench.startupEditor": "none",
  "workbench.tips.enabled": false,
  "workbench.enableExperiments": false,
  "workbench.secondarySideBar.defaultVisibility": "hidden",
  "chat.disableAIFeatures": true,
  "workbench.colorTheme": "Default Dark Modern",
  "editor.minimap.enabled": false,
  "files.autoSave": "off",
};

const PATIENCE = 60_000; // ms; a busy machine is no failure

/** Starts all of it on the folder; `stop` ends all of it. */
export async function open(folder) {
  rmSync(home, { recursive: true, force: true });
  for (const place of ["User", "Machine"]) {
    mkdirSync(join(home, "data", place), { recursive: true });
    writeFileSync(join(home, "data", place, "settings.json"), JSON.stringify(SETTINGS, null, 1));
  }
  const common = [
    ...["--config", join(home, "config.yaml")],
    ...["--user-data-dir", join(home, "data"), "--extensions-dir", join(home, "extensions")],
  ];
  writeFileSync(join(home, "config.yaml"), "auth: none\ncert: false\n");
  const root = resolve("../..");
  const env = {
    ...process.env,
    PYTHONPATH: root,
    HOME: home,
    PATH: `${join(installed, "node", "bin")}:${process.env.PATH}`,
  };
  const vsix = resolve("olp.vsix");
  execFileSync(node, [entry, ...common, "--install-extension", vsix], { env, stdio: "pipe" });

  const port = await free();
  const words = ["--bind-addr", `127.0.0.1:${port}`, "--disable-telemetry", "--disable-update-check"];
  const more = ["--disable-workspace-trust", "--disable-getting-started-override", folder];
  const server = spawn(node, [entry, ...common, ...words, ...more], { env, stdio: "pipe", detached: true });
  let said = "";
  for (const stream of [server.stdout, server.stderr]) stream.on("data", (data) => (said += data));
  await until(
    () => said.includes("HTTP server listening"),
    30_000,
    () => said,
  );

  const browser = await chromium.launch({ executablePath: "/usr/bin/chromium", args: QUIET });
  const context = await browser.newContext({ viewport: { width: 1280, height: 800 } });
  context.setDefaultTimeout(PATIENCE);
  const page = await context.newPage();
  await page.goto(`http://127.0.0.1:${port}/?folder=${encodeURIComponent(folder)}`);
  await page.locator(".monaco-workbench").waitFor({ timeout: 60_000 });
  return {
    page,
    async stop() {
      await browser.close();
      process.kill(-server.pid);
    },
  };
}

/** Waits until `holds`, and fails with what `told` says. */
export async function until(holds, patience = PATIENCE, told = () => holds.toString()) {
  const end = Date.now() + patience;
  while (!(await holds())) {
    if (Date.now() > end) throw new Error(`not within ${patience} ms: ${await told()}`);
    await new Promise((done) => setTimeout(done, 50));
  }
}

function free() {
  return new Promise((done) => {
    const probe = createServer().listen(0, "127.0.0.1", () => {
      const { port } = probe.address();
      probe.close(() => done(port));
    });
  });
}
