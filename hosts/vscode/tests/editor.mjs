/** VS Code's window, in the words of somebody who uses it. */

import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { until } from "./code-server.mjs";

export class Editor {
  constructor(page, folder) {
    this.page = page;
    this.folder = folder;
  }

  async openFile(name) {
    if ((await this.page.locator(".editor-instance").count()) > 0) await this.focus(); // not behind the side view
    await this.page.keyboard.press("Control+P");
    await this.choose(name, name);
    await this.seesTab(name);
  }

  async seesTab(name) {
    await this.page.locator(`.tab.active[data-resource-name="${name}"]`).first().waitFor();
  }

  /** A command, by the palette. */
  async command(title) {
    await this.page.keyboard.press("F1");
    await this.choose(`>${title}`, title);
  }

  async choose(typed, row) {
    const input = this.page.locator(".quick-input-widget:visible input").first();
    await input.waitFor();
    await input.fill(typed);
    const found = this.page.locator(".quick-input-list .monaco-list-row", { hasText: row }).first();
    await found.waitFor();
    await found.click();
    await this.page.mouse.move(0, 0); // over nothing that would explain itself in a picture
  }

  /** Types into what the editor asks, and confirms. */
  async answer(typed) {
    const input = this.page.locator(".quick-input-widget:visible input:visible").first();
    await input.waitFor();
    // A dialog about files writes its own proposal first, and looks at folders as they are typed.
    for (let calm = false; !calm; calm = (await input.inputValue()) === typed) {
      await input.fill(typed);
      await this.page.waitForTimeout(700);
    }
    await this.page.keyboard.press("Enter");
  }

  /** A message in the corner. */
  async told(expected) {
    await this.page.locator(".notification-list-item-message", { hasText: expected }).first().waitFor();
  }

  /** A button of a message in the corner. */
  async press(message, button) {
    const told = this.page.locator(".notification-list-item", { hasText: message });
    await told.locator(".monaco-button", { hasText: button }).click();
  }

  /** What an entry of the status bar says, by the end of its id. */
  async status(id) {
    return (await this.page.locator(`.statusbar-item[id$="${id}"]`).innerText()).trim();
  }

  lines() {
    return this.page
      .locator(".editor-instance .view-line")
      .allInnerTexts()
      .then((all) => all.map((t) => t.replace(/\u00a0/g, " ")));
  }

  async sees(expected) {
    const seen = async () => (await this.lines()).some((line) => expected.test(line));
    await until(seen, undefined, async () => `${expected} in:\n${(await this.lines()).join("\n")}`);
  }

  async seesLens(expected) {
    const lenses = this.page.locator(".codelens-decoration");
    const texts = async () =>
      (await lenses.allInnerTexts())
        .join(" | ")
        .replace(/\u00a0/g, " ")
        .split(" | ");
    const seen = async () => (await texts()).some((text) => expected.test(text));
    await until(seen, undefined, async () => `${expected} in ${await texts()}`);
  }

  /** What is said about the place of the cursor. */
  async hover() {
    await this.command("Show or Focus Hover");
    const said = this.page.locator(
      ".monaco-hover:visible .hover-contents, .monaco-hover:visible .markdown-hover",
    );
    await said.first().waitFor();
    const text = (await said.allInnerTexts()).join("\n").replace(/\u00a0/g, " ");
    return text;
  }

  async colours(start) {
    const line = this.page
      .locator(".editor-instance .view-line", { hasText: start.replace(/ /g, "\u00a0") })
      .first();
    return line
      .locator("span > span")
      .evaluateAll((parts) => parts.map((part) => getComputedStyle(part).color));
  }

  /** The line of the cursor, whichever window has the focus. */
  async line() {
    const number = this.page.locator(".editor-instance .active-line-number").first();
    return Number(await number.innerText());
  }

  /** Puts the cursor on the first line with that text, by the editor's own search. */
  async goToText(text) {
    await this.focus();
    await this.page.keyboard.press("Control+Home");
    await this.page.keyboard.press("Control+F");
    const input = this.page.locator(".find-widget.visible textarea").first();
    await input.waitFor();
    await input.fill(text);
    const count = this.page.locator(".find-widget .matchesCount");
    await until(async () => /of \d/.test(await count.textContent()));
    if ((await count.textContent()).startsWith("?")) await this.page.keyboard.press("Enter"); // searched before
    await until(async () => /\d of \d/.test(await count.textContent()));
    await until(async () => {
      await this.page.keyboard.press("Escape"); // the first may close a message instead
      return !(await this.page.locator(".find-widget.visible").isVisible());
    });
  }

  async focus() {
    await this.page.keyboard.press("Control+1");
    await this.page.locator(".monaco-editor.focused").first().waitFor();
  }

  async typeAtEnd(text) {
    await this.page.keyboard.press("End");
    await this.page.keyboard.type(text);
  }

  async undoAll() {
    await this.focus();
    await this.command("File: Revert File");
  }

  async seesProblem(expected) {
    const rows = this.page.locator(".markers-panel .monaco-list-row");
    await until(async () => (await rows.allInnerTexts()).some((row) => expected.test(row)));
  }

  /** The settings of the workspace, as a hand in its settings.json would change them. */
  set(settings) {
    mkdirSync(join(this.folder, ".vscode"), { recursive: true });
    writeFileSync(join(this.folder, ".vscode", "settings.json"), JSON.stringify(settings, null, 1));
  }

  view() {
    return this.page.frameLocator("iframe.webview.ready").frameLocator("#active-frame");
  }

  /** The chosen segment, as the side view says it. */
  facts() {
    return this.view()
      .locator("#facts")
      .evaluate((list) => {
        const names = [...list.querySelectorAll("dt")];
        return Object.fromEntries(
          names.map((name) => [name.textContent, name.nextElementSibling.textContent]),
        );
      });
  }

  /** A click at a time, as a share of all, in the row of a kind. */
  async clickSegment(share) {
    const canvas = this.view().locator("#gantt");
    const { width, height } = await canvas.boundingBox();
    await canvas.click({ position: { x: 58 + (width - 64) * share, y: height * 0.35 } });
  }

  painted(canvas) {
    return this.view()
      .locator(canvas)
      .evaluate((drawn) => {
        const copy = new OffscreenCanvas(drawn.width, drawn.height).getContext("2d");
        copy.drawImage(drawn, 0, 0); // of a picture in space, too
        const { data } = copy.getImageData(0, 0, drawn.width, drawn.height);
        const seen = new Set(new Uint32Array(data.buffer));
        return { colours: seen.size, width: drawn.width };
      });
  }

  picture(canvas) {
    return this.view()
      .locator(canvas)
      .evaluate((drawn) => drawn.toDataURL());
  }
}
