/** The language server `olp lsp`: started, kept, told of settings. */
import { type ChildProcess, spawn } from "node:child_process";
import { commands, type Disposable, EventEmitter, type LogOutputChannel, window, workspace } from "vscode";
import {
  CloseAction,
  ErrorAction,
  LanguageClient,
  RevealOutputChannelOn,
  State,
} from "vscode-languageclient/node";
import { LANGUAGES } from "./languages";
import { summary, tellMissing } from "./olp";
import { command, settings } from "./settings";

const SUFFIXES = ["toml", "jbi", "cnd", "src", "dat", "sub", "mod", "modx", "prg", "sys", "ls", "script"];
const NEEDED = SUFFIXES.flatMap((suffix) => [suffix, suffix.toUpperCase()]);
const BUNDLE_MS = 600;
const LONGEST_LAST_WORDS = 10_000; // characters of what a server has said before it ended

export class Server implements Disposable {
  private client: LanguageClient | undefined;
  private readonly changed = new EventEmitter<void>();
  /** The server has started or stopped, or times by other settings. */
  readonly onChange = this.changed.event;

  /** Files that decide about times without being open: called programs, data lists, olp.toml, signatures. */
  private readonly files = workspace.createFileSystemWatcher(`**/*.{${NEEDED.join(",")}}`);

  constructor(private readonly log: LogOutputChannel) {
    // The client tells the server of changed files in bundles.
    const soon = () => setTimeout(() => this.changed.fire(), BUNDLE_MS);
    for (const event of [this.files.onDidChange, this.files.onDidCreate, this.files.onDidDelete]) event(soon);
  }

  get isRunning(): boolean {
    return this.client?.state === State.Running;
  }

  /** The answer to a question of ours; undefined where no server runs or it does not know. */
  async ask<Answer>(method: string, question: object): Promise<Answer | undefined> {
    if (!this.client || !this.isRunning) return undefined;
    try {
      return (await this.client.sendRequest<Answer | null>(method, question)) ?? undefined;
    } catch (problem) {
      this.log.warn(`${method}: ${String(problem)}`);
      return undefined;
    }
  }

  async start(): Promise<void> {
    let told = "";
    const child = await launched((text) => {
      told = (told + text).slice(-LONGEST_LAST_WORDS);
      this.log.info(text.trimEnd());
    });
    if (!child) {
      this.changed.fire();
      await tellMissing();
      return;
    }
    const client = new QuietClient("olp", "olp", () => Promise.resolve(child), {
      documentSelector: LANGUAGES.map((language) => ({ scheme: "file", language })),
      initializationOptions: settings(),
      synchronize: { fileEvents: this.files },
      outputChannel: this.log,
      revealOutputChannelOn: RevealOutputChannelOn.Never,
      middleware: {
        // The total above a program only tells; here a click on it shows the pictures.
        async provideCodeLenses(document, token, next) {
          const lenses = (await next(document, token)) ?? [];
          for (const { command } of lenses) if (command?.command === "") command.command = "olp.view";
          return lenses;
        },
      },
      initializationFailedHandler: () => false,
      errorHandler: {
        error: () => ({ action: ErrorAction.Continue, handled: true }),
        closed: () => ({ action: CloseAction.DoNotRestart, handled: true }),
      },
    });
    this.client = client;
    client.onDidChangeState(({ oldState, newState }) => {
      this.changed.fire();
      if (oldState === State.Running && newState === State.Stopped && this.client === client)
        void ended(told);
    });
    try {
      await client.start();
    } catch (problem) {
      await ended(told || String(problem));
    }
  }

  async restart(): Promise<void> {
    const before = this.client;
    this.client = undefined;
    await before?.dispose().catch(() => undefined);
    await this.start();
  }

  /** The settings have changed: everything is timed anew. */
  async configure(): Promise<void> {
    if (!this.isRunning) return;
    await this.client?.sendNotification("workspace/didChangeConfiguration", {
      settings: { olp: settings() },
    });
    this.changed.fire();
  }

  dispose(): void {
    this.changed.dispose();
    this.files.dispose();
    void this.client?.dispose().catch(() => undefined);
  }
}

/** What goes wrong is told once, by `Server`, in words that help. */
class QuietClient extends LanguageClient {
  override error(message: string, data?: unknown): void {
    super.error(message, data, false);
  }
}

/** Starts `olp lsp`; undefined where there is no such program. */
function launched(hear: (text: string) => void): Promise<ChildProcess | undefined> {
  const [program = "olp", ...words] = command();
  return new Promise((done) => {
    const child = spawn(program, [...words, "lsp"], { env: { ...process.env, NO_COLOR: "1" } });
    child.stderr.setEncoding("utf8").on("data", hear);
    child.once("error", () => done(undefined));
    child.once("spawn", () => done(child));
  });
}

async function ended(told: string): Promise<void> {
  const chosen = await window.showErrorMessage(
    `olp's language server has ended: ${summary(told)}`,
    "Start Again",
  );
  if (chosen) await commands.executeCommand("olp.restart");
}
