"use strict";
(() => {
  const $ = (id) => document.getElementById(id);
  const root = document.documentElement;
  const css = (name) => getComputedStyle(root).getPropertyValue("--" + name).trim();
  const dark = () => (root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme:dark)").matches);
  const fixed = (value, digits) => (value === null || value === undefined ? "" : value.toFixed(digits));
  const PAGE = 400; // rows of the table that are there at once
  const ON_PAPER = 40; // rows that are printed, as in report.css

  // In an editor's side view the page follows the editor's cursor and text, and says where the reader clicks.
  const editor = typeof acquireVsCodeApi === "function" ? acquireVsCodeApi() : null;
  // A page of the same server around this one (olp serve) is told where the reader clicks, too.
  const framed = parent !== window && location.origin !== "null";

  // The program on show: its data, and what follows from them.
  let d = null, shown = -1, on = -1, ends = [], begins = [], now = 0, order = [], kept = [], top = 0, texts = new Map();

  const keyOf = (step) => d.file[step] + ":" + d.line[step];
  const text = (step) => texts.get(keyOf(step)) || "";
  const length = () => ends[ends.length - 1] || 1;

  /** The last place in ascending `values` that is not beyond `value`; 0 where all are. */
  const before = (values, value) => {
    let low = 0, high = values.length - 1;
    while (low < high) { const mid = (low + high + 1) >> 1; if (values[mid] <= value) low = mid; else high = mid - 1; }
    return low;
  };
  /** The segment that runs at a time [s]. */
  const stepAt = (time) => {
    let low = 0, high = ends.length - 1;
    while (low < high) { const mid = (low + high) >> 1; if (ends[mid] < time) low = mid + 1; else high = mid; }
    return low;
  };

  const KINDS = { joint: "blue", linear: "teal", circular: "olive", spline: "pink", wait: "orange", signal: "red" };
  const page = {
    $, css, before,
    tone: (kind) => css(KINDS[kind] || "frame") || "#888",
    ramp: () => (dark() ? [[95, 130, 255], [225, 105, 175], [255, 205, 95]] : [[45, 35, 160], [200, 55, 120], [245, 140, 30]]),
    /** A round number that is not below `value`. */
    round: (value) => {
      const power = 10 ** Math.floor(Math.log10(value || 1));
      return [1, 2, 5, 10].map((f) => f * power).find((step) => step >= value * (1 - 1e-9));
    },
    /** What is said of a segment beside the pointer. */
    describe: (step, short = false) => {
      if (step < 0 || step >= ends.length) return [];
      const takes = d.seconds[step] === null ? "not timed" : d.seconds[step].toFixed(3) + " s";
      const told = ["line " + d.line[step] + ": " + text(step)];
      if (short) return told;
      const reached = d.reached[step] === null ? "" : d.reached[step].toFixed(0) + " mm/s", rule = d.rules[d.rule[step]];
      return [...told, [d.kinds[d.kind[step]], takes, reached].filter(Boolean).join(", "), rule ? "limited by " + rule : ""];
    },
    tip: (e, says = []) => {
      const tip = $("tip"), told = says.filter(Boolean);
      tip.hidden = !e || !told.length;
      if (tip.hidden) return;
      tip.replaceChildren(...told.map((line) => { const row = document.createElement("div"); row.textContent = line; return row; }));
      const { width, height } = tip.getBoundingClientRect();
      tip.style.left = Math.max(4, Math.min(innerWidth - width - 8, e.clientX + 14)) + "px";
      tip.style.top = (e.clientY + height + 20 > innerHeight ? e.clientY - height - 12 : e.clientY + 16) + "px";
    },
    key: (id, names) => $(id).replaceChildren(...names.map(([name, tone]) => {
      const key = document.createElement("i"), both = document.createElement("span");
      key.className = "key"; key.style.background = tone;
      both.className = "named";
      both.append(key, name);
      return both;
    })),
    pick: (step, time) => pick(step, true, time),
  };
  const charts = makeCharts(page), space = makeSpace(page);

  // One program at a time; its data are unpacked when it is asked for.
  const unpacked = async (holder) => {
    const bytes = Uint8Array.from(atob(holder.textContent), (c) => c.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).json();
  };
  const open = async (index) => {
    const holder = $("d" + index);
    if (!holder || index === shown) return;
    shown = index;
    $("pick").value = index;
    const data = await unpacked(holder);
    if (index === shown) show(data, [...$("pick").options].find((o) => +o.value === index).text);
  };

  const show = (data, title) => {
    stop();
    on = -1;
    delete $("view").dataset.on;
    $("view").hidden = data === null;
    if ($("none")) $("none").hidden = data !== null;
    d = data;
    if (data === null) return;
    let end = 0;
    begins = []; ends = [];
    for (const seconds of d.seconds) { begins.push(end); end += seconds || 0; ends.push(end); }
    now = 0;
    texts = new Map(d.files.flatMap((file) => file.lines.map((line, i) => [file.index + ":" + (file.numbers ? file.numbers[i] : i + 1), line.trim()])));
    order = d.seconds.map((_, step) => step);
    $("search").value = "";
    for (const head of document.querySelectorAll("#segments th")) head.removeAttribute("aria-sort");
    const part = d.of > d.seconds.length ? " in the first " + d.seconds.length + " of " + d.of + " segments" : "";
    $("view-h").textContent = title + ": " + end.toFixed(3) + " s" + part;
    $("speed-f").hidden = !d.profile;
    $("axes-f").hidden = !d.arm;
    $("space-f").hidden = !d.path;
    $("time").max = end; $("time").step = end / 1000 || 1;
    facts(-1);
    search(); listing(); draw(false); clock();
  };

  const model = () => ({ d, begins, ends, end: ends[ends.length - 1] || 0, stepAt });
  /** Draws all pictures anew: another program, or (`keep`) other colours. */
  const draw = (keep) => {
    if (!d) return;
    page.ramp().forEach((tone, i) => root.style.setProperty("--ramp" + i, "rgb(" + tone.join(" ") + ")"));
    page.key("legend", d.kinds.map((kind) => [kind, page.tone(kind)]));
    charts.show(model(), keep);
    if (seen) space.show(model(), keep);
  };
  // The picture in space costs most: it is made when it comes into sight.
  let seen = false;
  new IntersectionObserver((found, observer) => {
    if (!found.some((entry) => entry.isIntersecting)) return;
    observer.disconnect();
    see();
  }, { rootMargin: "300px" }).observe($("space-f"));
  const see = () => {
    if (seen) return;
    seen = true;
    if (!d) return;
    space.show(model());
    space.choose(on);
    space.at(now);
    root.dataset.space = Math.round(performance.now());
  };

  // Playback: an instant, shown in all pictures.
  let playing = 0, last = 0;
  const clock = () => {
    $("time").value = now;
    $("clock").textContent = now.toFixed(2) + " of " + (ends[ends.length - 1] || 0).toFixed(2) + " s";
    $("time").ariaValueText = now.toFixed(2) + " s" + (on < 0 ? "" : ", line " + d.line[on]);
  };
  const setTime = (time) => {
    now = time;
    charts.at(now);
    space.at(now);
    clock();
  };
  /** Goes to a time [s]: the segment that runs then is chosen. */
  const at = (time) => {
    if (!d || !ends.length) return;
    const inside = Math.min(length(), Math.max(0, time)), step = stepAt(inside);
    if (step !== on) choose(step, true);
    setTime(inside);
  };
  const stop = () => {
    if (playing) cancelAnimationFrame(playing);
    playing = 0;
    $("play").textContent = "Play";
  };
  const frame = (time) => {
    at(now + ((time - last) / 1000) * +$("rate").value);
    last = time;
    if (now >= length()) stop(); else playing = requestAnimationFrame(frame);
  };
  $("play").addEventListener("click", () => {
    if (playing) return stop();
    see();
    if (now >= length() - 1e-6) at(0);
    $("play").textContent = "Pause";
    last = performance.now();
    playing = requestAnimationFrame(frame);
  });
  $("time").addEventListener("input", () => at(+$("time").value));

  // Chosen by the reader: an editor goes there, too.
  const pick = (step, scroll, time) => {
    stop();
    choose(step, scroll);
    if (on !== step) return;
    setTime(time ?? begins[step]);
    const chosen = { file: d.file[step], line: d.line[step] };
    if (editor) editor.postMessage(chosen);
    else if (framed) parent.postMessage(chosen, location.origin);
  };

  const facts = (step) => {
    if (step < 0) { $("facts").replaceChildren(...$("nothing").content.cloneNode(true).children); return; }
    const percent = d.percent[step];
    const all = [
      ["line", d.line[step] + (d.file[step] ? " of " + (d.files.find((f) => f.index === d.file[step]) || {}).name : "")],
      ["statement", text(step)],
      ["kind", d.kinds[d.kind[step]]],
      ["from", begins[step].toFixed(3) + " s"],
      ["takes", d.seconds[step] === null ? "not timed" : d.seconds[step].toFixed(3) + " s"],
      ["95 % interval", d.low && d.low[step] !== null ? d.low[step].toFixed(3) + " to " + d.high[step].toFixed(3) + " s" : ""],
      ["limited by", d.rules[d.rule[step]]],
      ["distance", d.mm[step] === null ? "" : d.mm[step] + " mm"],
      ["programmed", percent !== null ? percent + " %" : d.speed[step] === null ? "" : d.speed[step] + " mm/s"],
      ["reached", d.reached[step] === null ? "" : d.reached[step] + " mm/s"],
      ["acceleration", d.accel[step] === null ? "" : d.accel[step] + " mm/s²"],
    ];
    $("facts").replaceChildren(...all.filter(([, value]) => value !== "").flatMap(([name, value]) => {
      const dt = document.createElement("dt"), dd = document.createElement("dd");
      dt.textContent = name; dd.textContent = value;
      return [dt, dd];
    }));
  };
  // The chosen segment, in every picture.
  const choose = (step, scroll) => {
    if (!d || step < 0 || step >= ends.length) return;
    on = step;
    $("view").dataset.on = step;
    facts(step);
    if (!playing) $("told").textContent = "line " + d.line[step] + ": " + (d.seconds[step] === null ? "not timed" : d.seconds[step].toFixed(3) + " s");
    for (const old of document.querySelectorAll("#view .on")) old.classList.remove("on");
    const place = scroll ? kept.indexOf(step) : -1;
    if (place >= 0 && (place < top || place >= top + PAGE)) table(place - PAGE / 4);
    const row = document.querySelector('#segments tr[data-step="' + step + '"]');
    const line = document.querySelector('#text div[data-at="' + keyOf(step) + '"]');
    for (const mark of [row, line]) if (mark) mark.classList.add("on");
    if (scroll) for (const [mark, box] of [[row, $("segments").parentElement], [line, $("text")]])
      if (mark && mark.parentElement) box.scrollTop = mark.offsetTop - box.offsetTop - box.clientHeight / 2;
    charts.choose(step);
    space.choose(step);
  };

  // The table: sorted and searched in the data, made in pieces.
  const keys = [(s) => d.line[s], (s) => d.seconds[s], text, (s) => d.kinds[d.kind[s]], (s) => d.mm[s], (s) => d.speed[s] ?? d.percent[s], (s) => d.reached[s], (s) => d.rules[d.rule[s]], (s) => ends[s]];
  const RIGHT = new Set([1, 4, 5, 6, 8]); // columns of numbers
  const search = () => {
    const words = $("search").value.toLowerCase().split(/\s+/).filter(Boolean);
    kept = words.length ? order.filter((s) => {
      const all = (text(s) + " " + d.kinds[d.kind[s]] + " " + d.rules[d.rule[s]]).toLowerCase();
      return words.every((word) => (/^\d+$/.test(word) && String(d.line[s]) === word) || all.includes(word));
    }) : order;
    table(0);
  };
  /** The rows from the place `begin` on. */
  const table = (begin) => {
    top = Math.max(0, Math.min(begin, kept.length - PAGE));
    const body = document.createElement("tbody");
    for (const s of kept.slice(top, top + PAGE)) {
      const row = body.insertRow();
      row.dataset.step = s;
      if (s === on) row.className = "on";
      const v = d.percent[s] !== null ? d.percent[s] + " %" : fixed(d.speed[s], 1);
      [d.line[s], d.seconds[s] === null ? "unknown" : d.seconds[s].toFixed(3), text(s), d.kinds[d.kind[s]], fixed(d.mm[s], 1), v, fixed(d.reached[s], 0), d.rules[d.rule[s]], ends[s].toFixed(3)].forEach((value, i) => {
        const cell = row.insertCell();
        cell.textContent = value;
        if (RIGHT.has(i)) cell.className = "r";
      });
    }
    $("segments").tBodies[0].replaceWith(body);
    const end = Math.min(kept.length, top + PAGE);
    $("cut").textContent = end - top > ON_PAPER ? "Rows " + (top + 1) + " to " + (top + ON_PAPER) + " of " + kept.length + "; the page on a screen has all that it holds." : "";
    $("earlier").hidden = top === 0;
    $("later").hidden = end === kept.length;
    $("count").textContent = kept.length + " of " + order.length + " segments" + (kept.length > PAGE ? ", rows " + (top + 1) + " to " + end + " shown" : "");
  };

  const listing = () => {
    if (editor) return; // the text stands beside it
    const sums = {}, first = {};
    d.seconds.forEach((seconds, step) => {
      const key = keyOf(step);
      sums[key] = (sums[key] || 0) + (seconds || 0);
      if (!(key in first)) first[key] = step;
    });
    const parts = [];
    for (const file of d.files) {
      if (d.files.length > 1) {
        const head = document.createElement("h4");
        head.textContent = file.name;
        parts.push(head);
      }
      file.lines.forEach((line, i) => {
        const number = file.numbers ? file.numbers[i] : i + 1, key = file.index + ":" + number;
        const row = document.createElement("div"), a = document.createElement("span"), b = document.createElement("b"), c = document.createElement("code");
        a.textContent = number;
        b.textContent = key in sums ? sums[key].toFixed(3) : "";
        c.textContent = line;
        row.append(a, b, c);
        row.dataset.at = key;
        if (key in first) { row.className = "timed"; row.dataset.step = first[key]; }
        parts.push(row);
      });
    }
    $("text").replaceChildren(...parts);
  };

  // The same program with another text: what was chosen, zoomed and searched stays; without a time, all of it.
  const renew = (data, title) => {
    $("view").classList.toggle("stale", data === null && d !== null);
    if (data === null && d) { $("view-h").textContent = title + ": cannot be timed as it stands"; return; }
    const last = { d, on, now, view: charts.view, end: length(), words: $("search").value };
    const angle = space.keep();
    show(data, title);
    if (!d || !last.d) return;
    space.keep(angle);
    if (last.view[0] > 0 || last.view[1] < last.end) charts.look(...last.view);
    if (last.words) { $("search").value = last.words; search(); }
    if (last.on < 0) return;
    const file = last.d.file[last.on], line = last.d.line[last.on], runs = runsOf(d, file, line);
    if (!runs.length) return;
    const step = runs[Math.min(runsOf(last.d, file, line).indexOf(last.on), runs.length - 1)];
    choose(step, false);
    setTime(Math.max(begins[step], Math.min(ends[step], last.now)));
  };
  const runsOf = (data, file, line) => data.line.flatMap((l, step) => (l === line && data.file[step] === file ? [step] : []));

  // The first run of a line, unless another run of it is chosen already; a line that takes no time changes nothing.
  const goTo = (file, line) => {
    if (!d || (on >= 0 && d.file[on] === file && d.line[on] === line)) return;
    const [step] = runsOf(d, file, line);
    if (step === undefined) return;
    choose(step, true);
    setTime(begins[step]);
  };

  // Hands on.
  for (const id of ["gantt", "speed", "axes"]) $(id).addEventListener("keydown", (e) => {
    if (!d) return;
    const centre = on >= 0 ? (begins[on] + ends[on]) / 2 : undefined;
    if (e.key === "ArrowRight") pick(Math.min(ends.length - 1, on + 1), true);
    else if (e.key === "ArrowLeft") pick(Math.max(0, on - 1), true);
    else if (e.key === "+") charts.zoom(0.7, centre);
    else if (e.key === "-") charts.zoom(1.4, centre);
    else if (e.key === "0") charts.look(0, length());
    else if (e.key === " ") $("play").click();
    else return;
    e.preventDefault();
  });
  for (const button of document.querySelectorAll("[data-zoom]")) button.addEventListener("click", () => {
    const factor = +button.dataset.zoom;
    if (factor) charts.zoom(factor, now >= charts.view[0] && now <= charts.view[1] && now > 0 ? now : undefined);
    else charts.look(0, length());
  });
  for (const button of document.querySelectorAll("[data-fit]")) button.addEventListener("click", () => space.fit(button.dataset.fit));
  for (const button of document.querySelectorAll("[data-colour]")) button.addEventListener("click", () => {
    for (const other of document.querySelectorAll("[data-colour]")) other.setAttribute("aria-pressed", other === button);
    space.colour(button.dataset.colour);
  });
  $("segments").addEventListener("click", (e) => {
    const row = e.target.closest("tr[data-step]");
    if (row) pick(+row.dataset.step, false);
  });
  $("text").addEventListener("click", (e) => {
    const row = e.target.closest("div[data-step]");
    if (row) pick(+row.dataset.step, true);
  });
  $("search").addEventListener("input", search);
  for (const [id, way] of [["earlier", -1], ["later", 1]]) $(id).addEventListener("click", () => {
    table(top + way * PAGE);
    $("segments").parentElement.scrollTop = 0;
  });
  $("pick").addEventListener("change", () => { location.hash = "p" + $("pick").value; open(+$("pick").value); });

  const sortable = (table, sort) => [...table.tHead.rows[0].cells].forEach((head, column, heads) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const down = head.getAttribute("aria-sort") === "descending";
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", down ? "ascending" : "descending");
      sort(column, down ? 1 : -1);
    });
  });
  const by = (sign) => ([a], [b]) => sign * (typeof a === "number" && typeof b === "number" ? a - b
    : a === null || a === undefined ? -sign : b === null || b === undefined ? sign : String(a).localeCompare(String(b), "en", { numeric: true }));
  sortable($("segments"), (column, sign) => {
    order = d.seconds.map((_, s) => [keys[column](s), s]).sort(by(sign)).map(([, s]) => s);
    search();
  });
  sortable($("index"), (column, sign) => {
    const body = $("index").tBodies[0];
    const found = [...body.rows].map((row) => {
      const cell = row.cells[column].textContent, value = parseFloat(cell);
      return [row.cells[column].className.startsWith("r") ? (isNaN(value) ? null : value) : cell, row];
    });
    body.append(...found.sort(by(sign)).map(([, row]) => row));
  });

  const themed = () => draw(true);
  $("theme").hidden = false;
  $("theme").addEventListener("click", () => { root.dataset.theme = dark() ? "light" : "dark"; themed(); });
  matchMedia("(prefers-color-scheme:dark)").addEventListener("change", themed);
  new ResizeObserver(() => { charts.resize(); space.resize(); }).observe($("main"));

  // Paper: light, as wide as a sheet, and nothing folded away.
  const PAPER = [740, 400]; // px of a chart's width, and of the picture in space, as in report.css
  let folded = [], theme;
  addEventListener("beforeprint", () => {
    stop();
    theme = root.dataset.theme;
    root.dataset.theme = "light";
    folded = [...document.querySelectorAll("details:not([open])")];
    for (const part of folded) part.open = true;
    see();
    themed();
    charts.resize(PAPER[0]);
    space.resize(...PAPER);
  });
  addEventListener("afterprint", () => {
    if (theme) root.dataset.theme = theme; else delete root.dataset.theme;
    for (const part of folded) part.open = false;
    themed();
    charts.resize();
    space.resize();
  });

  const longest = +document.body.dataset.first;
  const follow = () => { const match = /^#p(\d+)$/.exec(location.hash); return open(match ? +match[1] : longest); };
  addEventListener("hashchange", async () => { await follow(); $("view").scrollIntoView(); });
  if (editor) {
    const worn = () => {
      root.dataset.theme = (document.body.dataset.vscodeThemeKind || "").includes("light") ? "light" : "dark";
      themed();
    };
    new MutationObserver(worn).observe(document.body, { attributes: true, attributeFilter: ["data-vscode-theme-kind", "data-vscode-theme-id"] });
    worn();
    addEventListener("message", ({ data: said }) => {
      if (said.program) renew(said.program.data, said.program.title);
      if (said.select) goTo(said.select.file, said.select.line);
    });
  }
  follow().then(() => {
    root.dataset.ready = Math.round(performance.now());
    if (editor) editor.postMessage({ ready: true });
  });
})();
