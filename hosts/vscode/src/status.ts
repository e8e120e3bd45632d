/** The total of the program in front, in the status bar. */
import { type Disposable, MarkdownString, StatusBarAlignment, window } from "vscode";
import { programIn } from "./languages";
import type { Server } from "./server";

interface Total {
  total_s: number | null;
  motion_s: number | null;
  wait_s: number | null;
  io_s: number | null;
  low_s: number | null;
  high_s: number | null;
  untimed: number;
  robot: string | null;
  model: string;
}

export class Status implements Disposable {
  private readonly item = window.createStatusBarItem("olp.total", StatusBarAlignment.Left, 10);
  private asked = 0;

  constructor(private readonly server: Server) {
    this.item.name = "olp: time of the program";
    this.item.command = "olp.view";
  }

  async refresh(): Promise<void> {
    const editor = programIn(window.activeTextEditor);
    if (!editor) {
      if (!window.activeTextEditor) return; // the side view is in front
      this.item.hide();
      return;
    }
    const question = ++this.asked;
    const total = await this.server.ask<Total>("olp/total", { uri: editor.document.uri.toString() });
    if (question !== this.asked) return; // a newer question is on its way
    this.item.text = total?.total_s == null ? "$(watch) no time" : `$(watch) ${total.total_s.toFixed(3)} s`;
    this.item.tooltip = this.explained(total);
    this.item.show();
  }

  private explained(total: Total | undefined): MarkdownString {
    if (!this.server.isRunning) return new MarkdownString("olp's language server does not run.");
    if (total?.total_s == null)
      return new MarkdownString("This program cannot be timed; the problems say why.");
    const said = new MarkdownString(
      `**${total.total_s.toFixed(3)} s** for one run, ${total.robot ?? "robot not known"}\n\n`,
    );
    said.appendMarkdown(
      `motion ${seconds(total.motion_s)}, waits ${seconds(total.wait_s)}, I/O ${seconds(total.io_s)}; ${total.model} model\n\n`,
    );
    if (total.low_s != null && total.high_s != null)
      said.appendMarkdown(`95 % interval ${total.low_s.toFixed(3)} to ${total.high_s.toFixed(3)} s\n\n`);
    if (total.untimed) said.appendMarkdown(`${total.untimed} steps could not be timed\n\n`);
    return said.appendMarkdown("A click shows path and times to the side.");
  }

  dispose(): void {
    this.item.dispose();
  }
}

function seconds(value: number | null): string {
  return value == null ? "unknown" : `${value.toFixed(3)} s`;
}
