/** Answers of olp as texts that can be read and searched, and not edited. */
import { type Disposable, EventEmitter, Uri, ViewColumn, window, workspace } from "vscode";

const SCHEME = "olp-answer";

export class Texts implements Disposable {
  private readonly known = new Map<string, string>();
  private readonly changed = new EventEmitter<Uri>();
  private readonly provider = workspace.registerTextDocumentContentProvider(SCHEME, {
    onDidChange: this.changed.event,
    provideTextDocumentContent: (uri) => this.known.get(uri.path) ?? "",
  });

  async show(name: string, text: string): Promise<void> {
    const uri = Uri.from({ scheme: SCHEME, path: name });
    this.known.set(uri.path, text);
    this.changed.fire(uri);
    const document = await workspace.openTextDocument(uri);
    await window.showTextDocument(document, {
      viewColumn: ViewColumn.Beside,
      preserveFocus: true,
      preview: true,
    });
  }

  dispose(): void {
    this.provider.dispose();
    this.changed.dispose();
  }
}
