/** Runs olp's command line, and says what to do where it is missing. */
import { execFile } from "node:child_process";
import { dirname } from "node:path";
import { commands, env, Uri, window, workspace } from "vscode";
import { command } from "./settings";

const INSTALL = 'pip install "olp[lsp]"';
const LONGEST_ANSWER = 64 * 1024 * 1024; // bytes

export interface Answer {
  /** 0 done and held, 1 a finding, 2 the question could not be answered. */
  status: number;
  out: string;
  told: string;
}

/** Undefined where there is no olp; the user has been told then. */
export async function run(words: string[], folder: string): Promise<Answer | undefined> {
  const [program = "olp", ...before] = command();
  const answer = await new Promise<Answer | "missing">((done) => {
    const options = { cwd: folder, maxBuffer: LONGEST_ANSWER, env: { ...process.env, NO_COLOR: "1" } };
    execFile(program, [...before, ...words], options, (problem, out, told) => {
      if (problem && ["ENOENT", "EACCES"].includes(String(problem.code))) done("missing");
      else done({ status: Number(problem?.code ?? 0), out, told });
    });
  });
  if (answer !== "missing") return answer;
  await tellMissing();
  return undefined;
}

export async function tellMissing(): Promise<void> {
  const said = `olp was not found as “${command().join(" ")}”. Install it with: ${INSTALL}`;
  const chosen = await window.showErrorMessage(said, "Copy the Command", "Say Where It Is");
  if (chosen === "Copy the Command") await env.clipboard.writeText(INSTALL);
  if (chosen === "Say Where It Is") {
    await commands.executeCommand("workbench.action.openSettings", "olp.command");
  }
}

/** What olp writes to its error stream, on one line: its first sentence and its help. */
export function summary(told: string): string {
  const said = told.split("\n").filter((line) => /^(?:error|warning)\[|^help:/.test(line));
  return said.slice(0, 2).join(" — ") || told.trim().split("\n").at(-1) || "olp gave no reason";
}

/** The folder of the workspace that has the file, or the file's own. */
export function folderOf(path: string): string {
  return workspace.getWorkspaceFolder(Uri.file(path))?.uri.fsPath ?? dirname(path);
}
