/** olp in VS Code: starts the server, and ties the editor's events to what is shown. */
import { commands, type ExtensionContext, window, workspace } from "vscode";
import { convert, report, time } from "./commands";
import { isProgram } from "./languages";
import { Server } from "./server";
import { Status } from "./status";
import { Texts } from "./texts";
import { View } from "./view";

// [ms] without a keystroke, before the total and the pictures are asked for anew
const TOTAL_AFTER = 150;
const PICTURES_AFTER = 300;

export function activate(context: ExtensionContext): void {
  const log = window.createOutputChannel("olp", { log: true });
  const server = new Server(log);
  const status = new Status(server);
  const view = new View(server);
  const texts = new Texts();

  const count = later(TOTAL_AFTER, () => status.refresh());
  const draw = later(PICTURES_AFTER, () => view.refresh());
  const refresh = () => {
    count();
    draw();
  };
  context.subscriptions.push(
    log,
    server,
    status,
    view,
    texts,
    commands.registerCommand("olp.view", () => view.open()),
    commands.registerCommand("olp.time", () => time(texts)),
    commands.registerCommand("olp.convert", () => convert(texts)),
    commands.registerCommand("olp.report", () => report(texts)),
    commands.registerCommand("olp.restart", () => server.restart()),
    server.onChange(refresh),
    workspace.onDidChangeTextDocument(({ document }) => isProgram(document) && refresh()),
    workspace.onDidChangeConfiguration(async (changed) => {
      if (changed.affectsConfiguration("olp.command")) await server.restart();
      else if (changed.affectsConfiguration("olp")) await server.configure();
    }),
    window.onDidChangeActiveTextEditor(async (editor) => {
      await Promise.all([status.refresh(), view.follow()]);
      await view.select(editor);
    }),
    window.onDidChangeTextEditorSelection(({ textEditor }) => view.select(textEditor)),
  );
  void server.start();
}

/** Calls once it has been quiet for a moment. */
function later(quiet: number, what: () => Promise<unknown>): () => void {
  let waiting: NodeJS.Timeout | undefined;
  return () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => void what(), quiet);
  };
}
