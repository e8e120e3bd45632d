"use strict";
(() => {
  const $ = (id) => document.getElementById(id);
  const root = document.documentElement;
  const seconds = (value) => (value === null || value === undefined ? "" : value.toFixed(3));
  const signed = (value) => (value >= 0 ? "+" : "−") + Math.abs(value).toFixed(3);
  const element = (tag, ...parts) => { const made = document.createElement(tag); made.append(...parts); return made; };
  const query = (given) => "?given=" + encodeURIComponent(JSON.stringify(given));

  // --- What goes wrong is told, and nothing is lost by it. ---

  const spoken = (d) => `${d.severity} ${d.code}: ${d.message}` + (d.file ? ` (${d.file}${d.line ? ":" + d.line : ""})` : "") + (d.help ? "\n" + d.help : "");
  const tell = (list, diagnostics) => list.replaceChildren(...diagnostics.map((d) => {
    const item = element("li", spoken(d));
    item.className = d.severity;
    return item;
  }));
  const lost = [{ severity: "error", code: "", message: "olp serve does not answer: has it been ended?", help: "start it again and open the new address" }];

  // The answer to a question; raises a list of diagnostics.
  const ask = async (what, body) => {
    let reply, told;
    try {
      reply = await fetch("api/" + what, { method: "POST", body: body instanceof FormData ? body : JSON.stringify(body) });
      told = await reply.json();
    } catch { throw lost; }
    if (!reply.ok) throw told.diagnostics;
    return told;
  };

  // Work that is waited for: says what, and what came of it.
  const during = async (says, work) => {
    $("busy").textContent = says;
    tell($("problems"), []);
    try { return await work(); } catch (problem) {
      if (!Array.isArray(problem)) throw problem;
      tell($("problems"), problem);
      return null;
    } finally { $("busy").textContent = ""; }
  };

  // --- Tables ---

  const heads = (table, names) => {
    table.tHead.rows[0].replaceChildren(...names.map((name) => {
      const head = element("th", name);
      head.scope = "col";
      if (/ s$| %$|^(runs|assumed|problems)$/.test(name)) head.className = "r";
      return head;
    }));
  };
  const fill = (table, rows) => {
    const body = element("tbody");
    for (const cells of rows) {
      const row = body.insertRow();
      cells.forEach((cell, i) => {
        const made = row.insertCell();
        made.append(cell instanceof Node ? cell : String(cell ?? ""));
        if (table.tHead.rows[0].cells[i].className) made.className = "r";
      });
    }
    table.tBodies[0].replaceWith(body);
    return [...body.rows];
  };
  const tile = (name, value, more, kind) => {
    const made = element("div", element("dt", name), element("dd", value, ...(more ? [element("small", more)] : [])));
    made.className = "tile " + (kind || "");
    return made;
  };
  const link = (file, text, line) => {
    const made = element("a", text);
    made.href = "#program=" + encodeURIComponent(file) + (line ? "&line=" + line : "");
    return made;
  };

  // --- The cell ---

  let cell = null, sorting = null;
  const COLUMNS = [["program", (p) => p.file], ["time s", (p) => p.total_s], ["motion s", (p) => p.motion_s], ["waits s", (p) => p.wait_s], ["I/O s", (p) => p.io_s], ["robot", (p) => p.robot], ["assumed", (p) => p.assumed || null], ["problems", (p) => p.problems || null]];

  const programs = () => {
    let shown = cell.programs;
    if (sorting) {
      const [column, sign] = sorting, key = COLUMNS[column][1];
      shown = [...shown].sort((a, b) => {
        const [x, y] = [key(a), key(b)];
        if (x === null || y === null) return (x === null) - (y === null);
        return sign * (typeof x === "number" ? x - y : String(x).localeCompare(String(y), "en", { numeric: true }));
      });
    }
    const rows = shown.map((p) => [link(p.file, p.file), p.total_s === null ? "not timed" : (p.partial ? "≥ " : "") + seconds(p.total_s), seconds(p.motion_s), seconds(p.wait_s), seconds(p.io_s), p.robot, p.assumed || "", p.problems || ""]);
    fill($("programs"), rows).forEach((row, i) => {
      if (!sorting) row.cells[0].style.paddingLeft = Math.min(shown[i].depth, 8) * 1.2 + "em";
    });
  };

  const showCell = () => {
    $("folder").textContent = cell.folder;
    titled();
    const several = cell.programs.length > 1;
    $("tiles").replaceChildren(
      tile("Programs", String(cell.programs.length), several ? `${cell.started} that a controller starts` : ""),
      tile("Time of what a controller starts", `${cell.partial ? "≥ " : ""}${seconds(cell.total_s)} s`, cell.spelled),
    );
    programs();
    const total = Object.values(cell.by_cause).reduce((a, b) => a + b, 0) || 1;
    heads($("causes"), ["cause", "time s", "share %", ""]);
    fill($("causes"), Object.entries(cell.by_cause).filter(([, v]) => v > 0).sort((a, b) => b[1] - a[1]).map(([cause, v]) => {
      const bar = element("span");
      bar.className = "bar-of-time";
      bar.style.width = (20 * v) / total + "em";
      return [cause, seconds(v), ((100 * v) / total).toFixed(1), bar];
    }));
    heads($("costliest"), ["time s", "share %", "runs", "line", "statement", "mostly", "what would help"]);
    fill($("costliest"), cell.lines.map((l) => [seconds(l.seconds), ((100 * l.seconds) / total).toFixed(1), l.runs, link(l.file, l.file.split(/[\\/]/).pop() + ":" + l.line, l.line), element("code", l.statement), l.cause, l.helps]));
    $("branches").replaceChildren(...cell.branches.map((says) => element("li", says)));
    $("findings").hidden = !cell.diagnostics.length;
    $("findings").firstElementChild.textContent = `${cell.diagnostics.length} finding${cell.diagnostics.length === 1 ? "" : "s"}`;
    $("findings").lastElementChild.replaceChildren(...cell.diagnostics.map((d) => element("li", spoken(d))));
    $("cell-told").hidden = false;
    const names = cell.programs.map((p) => p.file).sort((a, b) => a.localeCompare(b, "en", { numeric: true }));
    const options = (first) => [...first, ...names.map((name) => [name, name])].map(([value, says]) => new Option(says, value));
    $("old").replaceChildren(...options([["", "git: HEAD"]]));
    $("new").replaceChildren(...options([]));
    $("job").replaceChildren(...options([["", "as the recording says"]]));
  };
  heads($("programs"), COLUMNS.map(([name]) => name));
  [...$("programs").tHead.rows[0].cells].forEach((head, column, all) => {
    const button = element("button", ...head.childNodes);
    button.type = "button";
    head.replaceChildren(button);
    button.addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") !== "descending";
      for (const other of all) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", down ? "descending" : "ascending");
      sorting = [column, down ? -1 : 1];
      programs();
    });
  });

  // --- One program: its page, and what if ---

  let file = "", known = null, changes = new Map(), asked = 0, timer = 0;
  const MOST = 400; // rows that are shown at once

  const given = () => {
    const override = $("override").valueAsNumber;
    return {
      file,
      digest: known ? known.digest : "",
      changes: [...changes].map(([line, change]) => ({ line, ...change })),
      ...(known && override > 0 && override !== known.override ? { override } : {}),
    };
  };
  const changed = () => changes.size > 0 || "override" in given();

  const tiles = (total) => {
    const before = known.total_s, change = total - before;
    const least = known.partial ? "≥ " : "";
    const parts = [tile("Time as it is", `${least}${seconds(before)} s`)];
    if (changed()) parts.push(tile("With the changes", `${least}${seconds(total)} s`), tile("Change", signed(change) + " s", ((100 * change) / (before || 1)).toFixed(1) + " %", change > 5e-4 ? "bad" : ""));
    $("what-if-tiles").replaceChildren(...parts);
  };

  const times = (after) => {
    for (const row of $("lines").tBodies[0].rows) {
      const line = +row.dataset.line, was = known.seconds[line], now = after[line];
      row.classList.toggle("changed", changes.has(line));
      const cell = row.cells[3];
      const other = now !== undefined && was !== undefined && Math.abs(now - was) > 5e-7;
      cell.textContent = other ? seconds(now) : "";
      cell.className = "r " + (other ? (now < was ? "better" : "worse") : "");
    }
  };

  // Asks for the times of all changes; an answer that another question has overtaken is left out.
  const ponder = async () => {
    const number = ++asked, began = performance.now();
    for (const button of ["undo", "draw", "download"]) $(button).disabled = !changed();
    try {
      const told = await ask("what_if_times", given());
      if (number !== asked) return;
      tell($("refused"), told.diagnostics);
      tiles(told.total_s);
      times(told.seconds);
      root.dataset.answered = Math.round(performance.now() - began);
    } catch (problem) {
      if (!Array.isArray(problem)) throw problem;
      if (number !== asked) return;
      tell($("refused"), problem);
      for (const button of ["draw", "download"]) $(button).disabled = true;
    }
  };
  const soon = () => { clearTimeout(timer); timer = setTimeout(ponder, 60); };

  const change = (line, name, value) => {
    const all = { ...changes.get(line), [name]: value };
    if (value === null) delete all[name];
    if (Object.keys(all).length) changes.set(line, all); else changes.delete(line);
    soon();
  };

  const editor = (one) => {
    const parts = [];
    const change_ = changes.get(one.line) || {};
    if (one.speed !== null) {
      const input = element("input");
      Object.assign(input, { type: "number", step: "any", min: "0", value: String(change_.speed ?? one.speed) });
      input.setAttribute("aria-label", `speed of line ${one.line}, ${one.unit}`);
      input.addEventListener("input", () => {
        const value = input.valueAsNumber;
        change(one.line, "speed", Number.isFinite(value) && value !== one.speed ? value : null);
      });
      parts.push(input, " " + one.unit + (one.written === one.line ? "" : ` (line ${one.written})`));
    }
    if (!one.zones.length) return [element("span", ...parts), ""];
    const select = element("select", new Option("as it is", "0"), ...one.zones.map(([n, says]) => new Option(says, String(n))));
    select.value = String(change_.zone ?? 0);
    select.setAttribute("aria-label", `zone of line ${one.line}`);
    select.addEventListener("change", () => change(one.line, "zone", +select.value || null));
    return [element("span", ...parts), select];
  };

  const editors = () => {
    const words = $("filter").value.toLowerCase().split(/\s+/).filter(Boolean);
    const kept = known.lines.filter((one) => words.every((word) => String(one.line) === word || one.statement.toLowerCase().includes(word)));
    heads($("lines"), ["line", "statement", "time s", "then s", "speed", "zone"]);
    fill($("lines"), kept.slice(0, MOST).map((one) => [one.line, one.statement, seconds(one.seconds), "", ...editor(one)]))
      .forEach((row, i) => { row.dataset.line = kept[i].line; });
    $("shown").textContent = `${Math.min(kept.length, MOST)} of ${known.lines.length} lines`;
  };

  const drawPage = () => {
    const address = "page" + query(changed() ? given() : { file });
    $("report").src = address;
    $("alone").href = address;
    $("drawn").textContent = changed() ? "The program with the changes" : "The program as it is";
  };

  const showProgram = async (name, line) => {
    if (name !== file) {
      file = name;
      known = null;
      changes = new Map();
      asked++;
      $("program-h").textContent = name;
      for (const id of ["what-if-tiles", "refused"]) $(id).replaceChildren();
      for (const button of ["undo", "draw", "download"]) $(button).disabled = true;
      $("lines").tBodies[0].replaceChildren();
      $("filter").value = "";
      drawPage();
      const told = await during("Timing the program …", () => ask("what_if_lines", { file: name }));
      if (file !== name || !told) return;
      known = { ...told, seconds: Object.fromEntries(told.lines.map((one) => [one.line, one.seconds ?? undefined])) };
      $("override").value = String(told.override);
      tiles(told.total_s);
      editors();
    }
    const row = line && reach(line);
    if (row) row.scrollIntoView({ block: "center" });
  };

  // The row of a line, marked and within its table's view; undefined where the line cannot be changed.
  const reach = (line) => {
    for (const met of document.querySelectorAll(".met")) met.classList.remove("met");
    const row = [...$("lines").tBodies[0].rows].find((one) => one.dataset.line === line);
    if (row) {
      row.classList.add("met");
      const box = $("lines").parentElement;
      box.scrollTop = row.offsetTop - box.clientHeight / 2;
    }
    return row;
  };
  // The page of the program says which line is clicked; file 0 is the program itself.
  addEventListener("message", ({ origin, source, data }) => {
    if (origin === location.origin && source === $("report").contentWindow && data.file === 0) reach(String(data.line));
  });

  $("override").addEventListener("input", soon);
  $("filter").addEventListener("input", () => { if (known) { editors(); soon(); } });
  $("undo").addEventListener("click", () => {
    changes = new Map();
    $("override").value = String(known.override);
    editors();
    ponder();
  });
  $("draw").addEventListener("click", drawPage);
  $("download").addEventListener("click", async () => {
    const reply = await fetch("download" + query(given())).catch(() => null);
    if (!reply || !reply.ok) { tell($("refused"), lost); return; }
    const name = /filename="([^"]*)"/.exec(reply.headers.get("content-disposition") || "");
    const made = element("a");
    made.href = URL.createObjectURL(await reply.blob());
    made.download = name ? name[1] : "program";
    made.click();
    URL.revokeObjectURL(made.href);
  });

  // --- Two versions ---

  $("compare").addEventListener("click", async () => {
    $("changes").hidden = true;
    $("compared").replaceChildren();
    const told = await during("Comparing …", () => ask("compare", { old: $("old").value, new: $("new").value }));
    if (!told) return;
    $("compared").replaceChildren(...told.items.map((item) => element("p", element("strong", item.name), " " + item.message)), element("p", told.summary.join(" ")));
    const rows = told.programs.flatMap((p) => p.changes).sort((a, b) => Math.abs(b.change_s) - Math.abs(a.change_s));
    heads($("changes"), ["line", "statement", "old s", "new s", "change s", "cause", "details"]);
    fill($("changes"), rows.map((c) => [c.new_line ?? `(${c.old_line})`, element("code", c.statement), seconds(c.old_s), seconds(c.new_s), signed(c.change_s), c.cause, c.details]))
      .forEach((row, i) => row.cells[4].classList.add(rows[i].change_s > 0 ? "worse" : "better"));
    $("changes").hidden = !rows.length;
  });

  // --- A recording ---

  const diagnose = async (files) => {
    if (!files.length) return;
    location.hash = "recording";
    const form = new FormData();
    form.append("job", $("job").value);
    for (const [name, one] of files) form.append("file", one, name);
    $("diagnosis").hidden = true;
    const told = await during("Diagnosing the recording …", () => ask("diagnose", form));
    if (!told) return;
    $("diagnosis").src = told.page;
    $("diagnosis").hidden = false;
  };
  for (const id of ["files", "directory"]) $(id).addEventListener("change", () => {
    diagnose([...$(id).files].map((one) => [one.webkitRelativePath || one.name, one]));
    $(id).value = "";
  });

  // All files below what was dropped, folders included, with their paths.
  const within = async (entry, path) => {
    if (entry.isFile) return [[path + entry.name, await new Promise((done, failed) => entry.file(done, failed))]];
    const reader = entry.createReader(), found = [];
    for (;;) {
      const some = await new Promise((done, failed) => reader.readEntries(done, failed));
      if (!some.length) return found;
      for (const one of some) found.push(...await within(one, path + entry.name + "/"));
    }
  };
  let over = 0;
  const carries = (event) => [...(event.dataTransfer?.types || [])].includes("Files");
  addEventListener("dragenter", (event) => { if (carries(event)) { over++; $("drop").hidden = false; } });
  addEventListener("dragleave", (event) => { if (carries(event) && --over <= 0) { over = 0; $("drop").hidden = true; } });
  addEventListener("dragover", (event) => { if (carries(event)) event.preventDefault(); });
  addEventListener("drop", async (event) => {
    if (!carries(event)) return;
    event.preventDefault();
    over = 0;
    $("drop").hidden = true;
    const entries = [...event.dataTransfer.items].map((item) => item.webkitGetAsEntry && item.webkitGetAsEntry());
    const plain = [...event.dataTransfer.files].map((one) => [one.name, one]);
    diagnose(entries.every(Boolean) && entries.length ? (await Promise.all(entries.map((entry) => within(entry, "")))).flat() : plain);
  });

  // --- Views ---

  const dark = () => (root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme:dark)").matches);
  const themed = (frame) => {
    const inner = frame.contentDocument && frame.contentDocument.documentElement;
    if (inner && root.dataset.theme) inner.dataset.theme = root.dataset.theme;
  };
  const frames = ["report", "diagnosis"].map($);
  for (const frame of frames) frame.addEventListener("load", () => themed(frame));
  $("theme").addEventListener("click", () => { root.dataset.theme = dark() ? "light" : "dark"; frames.forEach(themed); });
  $("skip").addEventListener("click", (event) => { event.preventDefault(); $("main").focus(); });

  const titled = () => {
    const heading = document.querySelector("[data-view]:not([hidden]) h2").textContent;
    document.title = [heading, $("folder").textContent].join(" – ");
  };
  const follow = () => {
    const at = new URLSearchParams(location.hash.slice(1));
    const view = ["program", "compare", "recording"].find((name) => at.has(name)) || "cell";
    for (const section of document.querySelectorAll("[data-view]")) section.hidden = section.dataset.view !== view;
    for (const one of document.querySelectorAll("nav a")) {
      if (one.hash === "#" + view) one.setAttribute("aria-current", "page"); else one.removeAttribute("aria-current");
    }
    if (view === "program") showProgram(at.get("program"), at.get("line"));
    titled();
  };
  addEventListener("hashchange", () => { tell($("problems"), []); follow(); document.querySelector("[data-view]:not([hidden]) h2").focus(); scrollTo(0, 0); });
  follow();

  during("Timing the programs …", () => ask("cell", {})).then((told) => {
    if (!told) return;
    cell = told;
    showCell();
    root.dataset.ready = Math.round(performance.now());
  });
})();
