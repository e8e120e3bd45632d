/** The settings `olp.*`, as the server and as the command line want them. */
import { isAbsolute, resolve } from "node:path";
import { workspace } from "vscode";

export interface Settings {
  robot: string;
  signature: string;
  override: number;
  model: string;
}

export function settings(): Settings {
  const given = workspace.getConfiguration("olp");
  return {
    robot: inWorkspace(given.get("robot", "").trim(), /\.toml$/i),
    signature: inWorkspace(given.get("signature", "").trim(), /./),
    override: given.get("override", 100),
    model: given.get("model", "").trim(),
  };
}

/** A path counts from the first folder of the workspace; a robot may also be a name of olp's library. */
function inWorkspace(value: string, path: RegExp): string {
  const folder = workspace.workspaceFolders?.[0];
  return folder && path.test(value) && !isAbsolute(value) ? resolve(folder.uri.fsPath, value) : value;
}

/** The command that is olp, word by word. */
export function command(): string[] {
  const words = workspace.getConfiguration("olp").get<string[]>("command", ["olp"]);
  return words.length > 0 && words[0] ? words : ["olp"];
}

/** The settings as options of the commands that time a program. */
export function timingOptions(): string[] {
  const { robot, signature, override, model } = settings();
  return [
    ...(robot ? ["--robot", robot] : []),
    ...(signature ? ["--signature", signature] : []),
    ...(override !== 100 ? ["--override", String(override)] : []),
    ...(model ? ["--model", model] : []),
  ];
}
