/** Time, convert, report: olp's own commands for the program in front, with the settings of the editor. */
import { basename, extname, relative } from "node:path";
import { env, ProgressLocation, type TextEditor, Uri, window } from "vscode";
import { LANGUAGES, programIn } from "./languages";
import { type Answer, folderOf, run, summary } from "./olp";
import { settings, timingOptions } from "./settings";
import type { Texts } from "./texts";

/** The table of `olp time`, as a text beside the program. */
export async function time(texts: Texts): Promise<void> {
  const path = await saved();
  if (!path) return;
  const answer = await asked("Timing", ["time", path, ...timingOptions()], path);
  if (await done(answer, texts)) await texts.show(`${basename(path)} times`, text(answer));
}

/** Another robot's language: the new program is opened, its receipt stands beside. */
export async function convert(texts: Texts): Promise<void> {
  const editor = programIn(window.activeTextEditor);
  const path = await saved();
  if (!editor || !path) return;
  const others = LANGUAGES.filter((language) => language !== editor.document.languageId);
  const to = await window.showQuickPick(others, {
    title: `Convert ${basename(path)}`,
    placeHolder: "the language to write",
  });
  if (!to) return;
  const robot = await window.showInputBox({
    title: "The robot that the program is for",
    value: settings().robot,
    prompt: "as olp robots lists it, such as yaskawa/gp25; empty: what the program and olp.toml say",
  });
  if (robot === undefined) return;
  const chosen = await window.showOpenDialog({
    title: "The folder for the new program",
    canSelectFiles: false,
    canSelectFolders: true,
    defaultUri: Uri.file(folderOf(path)),
    openLabel: "Write Here",
  });
  const folder = chosen?.[0]?.fsPath;
  if (!folder) return;
  const words = ["convert", path, "--to", to, "-o", folder, ...(robot ? ["--robot", robot] : [])];
  let answer = await asked(`Converting to ${to}`, words, path);
  if (answer?.status === 2 && answer.told.includes("--on-loss comment")) {
    const losses = answer.told.match(/^error\[/gm)?.length ?? 0;
    const said = `${to} cannot say ${String(losses)} of the statements of ${basename(path)}.`;
    const choice = await window.showWarningMessage(said, "Write Them as Comments", "Show Them");
    if (choice === "Show Them") await texts.show(`${basename(path)} as ${to}`, answer.told);
    if (choice !== "Write Them as Comments") return;
    answer = await asked(`Converting to ${to}`, [...words, "--on-loss", "comment"], path);
  }
  if (await done(answer, texts)) await texts.show(`${basename(path)} as ${to}`, text(answer));
}

/** The page of `olp report`, in a file that the user names. */
export async function report(texts: Texts): Promise<void> {
  const path = await saved();
  if (!path) return;
  const page = await window.showSaveDialog({
    title: "Write a report",
    defaultUri: Uri.file(`${path.slice(0, -extname(path).length)}.html`),
    filters: { "HTML page": ["html"] },
  });
  if (!page) return;
  const answer = await asked(
    "Writing the report",
    ["report", path, "-o", page.fsPath, ...timingOptions()],
    path,
  );
  if (!(await done(answer, texts))) return;
  const chosen = await window.showInformationMessage(
    `${basename(page.fsPath)} is written.`,
    "Open in the Browser",
  );
  if (chosen) await env.openExternal(page);
}

/** The path of the program in front, whose text is on the disk then: the commands read files. */
async function saved(): Promise<string | undefined> {
  const editor: TextEditor | undefined = programIn(window.activeTextEditor);
  if (!editor) {
    void window.showInformationMessage("olp: open a robot program first.");
    return undefined;
  }
  if (editor.document.isDirty && !(await editor.document.save())) return undefined;
  return editor.document.uri.fsPath;
}

/** What olp answers; undefined where there is none. */
async function asked(title: string, words: string[], path: string): Promise<Answer | undefined> {
  const folder = folderOf(path);
  const short = relative(folder, path); // olp says the name that it was given
  const progress = { location: ProgressLocation.Window, title: `olp: ${title}` };
  return window.withProgress(progress, () =>
    run(
      words.map((word) => (word === path ? short : word)),
      folder,
    ),
  );
}

/** Whether olp could answer at all; otherwise it is said why. */
async function done(answer: Answer | undefined, texts: Texts): Promise<boolean> {
  if (!answer || answer.status < 2 || answer.out.trim()) return answer !== undefined;
  const chosen = await window.showErrorMessage(`olp: ${summary(answer.told)}`, "Show All");
  if (chosen) await texts.show("what olp says", answer.told);
  return false;
}

function text(answer: Answer | undefined): string {
  return [answer?.out, answer?.told].filter(Boolean).join("\n");
}
