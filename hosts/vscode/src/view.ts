/** The side view: the page of `olp report` for the program in front, which follows the cursor and leads it. */
import {
  type Disposable,
  Range,
  Selection,
  type TextEditor,
  TextEditorRevealType,
  Uri,
  ViewColumn,
  type WebviewPanel,
  window,
  workspace,
} from "vscode";
import { programIn } from "./languages";
import type { Server } from "./server";

/** What `olp/view` answers. `files`: the URIs by the numbers that `data` has for them; `html` on request. */
interface Drawn {
  html?: string;
  title: string;
  files: string[];
  data: unknown;
}

/** What the page says: that it is there, or where the reader has clicked. */
type Said = { ready: true } | { file: number; line: number };

export class View implements Disposable {
  private panel: WebviewPanel | undefined;
  private shown: Uri | undefined;
  private files: string[] = [];
  private asked = 0;
  private latest: Drawn | undefined;

  constructor(private readonly server: Server) {}

  /** Opens the view beside the program in front, or brings it up. */
  async open(): Promise<void> {
    const editor = programIn(window.activeTextEditor) ?? programIn(window.visibleTextEditors.find(programIn));
    if (!editor) return;
    if (!this.panel) this.panel = this.made();
    else this.panel.reveal(undefined, true);
    await this.show(editor.document.uri);
  }

  /** Another editor is in front: the view goes with it, unless it shows a file that the drawn program calls. */
  async follow(): Promise<void> {
    const uri = programIn(window.activeTextEditor)?.document.uri;
    if (!this.panel || !uri || this.files.includes(uri.toString())) return;
    await this.show(uri);
  }

  /** The drawn program, or one that it needs, or the settings have changed. */
  async refresh(): Promise<void> {
    if (!this.panel || !this.shown) return;
    if (!this.latest) return this.show(this.shown);
    const drawn = await this.drawn(this.shown, false);
    if (drawn) await this.send({ program: { title: drawn.title, data: drawn.data } });
  }

  /** The cursor stands on another line, perhaps while the view has the focus. */
  async select(editor: TextEditor | undefined): Promise<void> {
    const program = programIn(editor);
    const file = program ? this.files.indexOf(program.document.uri.toString()) : -1;
    if (program && file >= 0) await this.send({ select: { file, line: program.selection.active.line + 1 } });
  }

  private made(): WebviewPanel {
    const where = { viewColumn: ViewColumn.Beside, preserveFocus: true };
    const panel = window.createWebviewPanel("olp.view", "olp", where, {
      enableScripts: true,
      localResourceRoots: [],
    });
    panel.webview.onDidReceiveMessage((said: Said) => this.hear(said));
    panel.onDidChangeViewState(() => panel.visible && this.catchUp());
    panel.onDidDispose(() => {
      this.panel = this.shown = this.latest = undefined;
      this.files = [];
    });
    return panel;
  }

  private async show(uri: Uri): Promise<void> {
    this.shown = uri;
    this.latest = undefined;
    const drawn = await this.drawn(uri, true);
    if (!drawn || !this.panel) return;
    this.panel.title = drawn.title;
    this.panel.webview.html = drawn.html ?? "";
  }

  private async drawn(uri: Uri, page: boolean): Promise<Drawn | undefined> {
    const question = ++this.asked;
    const drawn = await this.server.ask<Drawn>("olp/view", { uri: uri.toString(), page });
    if (question !== this.asked || !drawn) return undefined;
    this.latest = drawn;
    this.files = drawn.files.map((file) => Uri.parse(file).toString());
    return drawn;
  }

  private async send(message: object): Promise<void> {
    await this.panel?.webview.postMessage(message);
  }

  /** A page that was hidden, or is new, has missed what was sent meanwhile. */
  private async catchUp(): Promise<void> {
    const { latest } = this;
    if (latest && !latest.html) await this.send({ program: { title: latest.title, data: latest.data } });
    await this.select(window.visibleTextEditors.find((editor) => this.isDrawn(editor)));
  }

  private isDrawn(editor: TextEditor): boolean {
    return editor.document.uri.toString() === this.shown?.toString();
  }

  private async hear(said: Said): Promise<void> {
    if ("ready" in said) return this.catchUp();
    const file = this.files[said.file];
    if (file) await reveal(Uri.parse(file), said.line);
  }

  dispose(): void {
    this.panel?.dispose();
  }
}

/** The line in the editor that shows its file already, in the first one otherwise; the view keeps the focus. */
async function reveal(uri: Uri, line: number): Promise<void> {
  const open = window.visibleTextEditors.find((editor) => editor.document.uri.toString() === uri.toString());
  const document = await workspace.openTextDocument(uri);
  const viewColumn = open?.viewColumn ?? ViewColumn.One;
  const editor = await window.showTextDocument(document, { viewColumn, preserveFocus: true });
  const start = document.validateRange(new Range(line - 1, 0, line - 1, 0)).start;
  editor.selection = new Selection(start, start);
  editor.revealRange(new Range(start, start), TextEditorRevealType.InCenterIfOutsideViewport);
}
