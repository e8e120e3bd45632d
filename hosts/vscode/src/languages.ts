/** The languages that package.json declares; their names are those of `olp`. */
import type { TextDocument, TextEditor } from "vscode";

export const LANGUAGES = ["inform", "krl", "rapid", "tp", "urscript"] as const;

export function isProgram(document: TextDocument | undefined): document is TextDocument {
  return document?.uri.scheme === "file" && (LANGUAGES as readonly string[]).includes(document.languageId);
}

export function programIn(editor: TextEditor | undefined): TextEditor | undefined {
  return isProgram(editor?.document) ? editor : undefined;
}
