"use strict";
(() => {
  const $ = (id) => document.getElementById(id);
  const root = document.documentElement;
  const css = (name) => getComputedStyle(root).getPropertyValue("--" + name).trim();
  const dark = () => (root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme:dark)").matches);
  const fixed = (value, digits) => (value === null || value === undefined ? "" : value.toFixed(digits));
  const PAGE = 400; // rows of the table that are made at once

  // In an editor's side view the page follows the editor's cursor and text, and says where the reader clicks.
  const editor = typeof acquireVsCodeApi === "function" ? acquireVsCodeApi() : null;

  let d = null, shown = -1, on = -1, ends = [], begins = [], from = 0, to = 1, colour = "time";
  let order = [], rows = PAGE, turn = [0.6, 0.5], zoom = 1, sums = [];

  const text = (step) => {
    const file = d.files.find((f) => f.index === d.file[step]);
    if (!file) return "";
    const at = file.numbers ? file.numbers.indexOf(d.line[step]) : d.line[step] - 1;
    return (file.lines[at] || "").trim();
  };

  // One program at a time; its data are read when it is asked for.
  const open = (index) => {
    const holder = $("d" + index);
    if (!holder || index === shown) return;
    shown = index;
    show(JSON.parse(holder.textContent), [...$("pick").options].find((o) => +o.value === index).text);
    $("pick").value = index;
  };

  const show = (data, title) => {
    on = -1;
    $("view").hidden = data === null;
    if ($("none")) $("none").hidden = data !== null;
    d = data;
    if (data === null) return;
    let end = 0;
    begins = []; ends = [];
    for (const seconds of d.seconds) { begins.push(end); end += seconds || 0; ends.push(end); }
    from = 0; to = end || 1; zoom = 1;
    order = d.seconds.map((_, step) => step);
    rows = PAGE;
    $("search").value = "";
    for (const head of document.querySelectorAll("#segments th")) head.removeAttribute("aria-sort");
    const part = d.of > d.seconds.length ? " in the first " + d.seconds.length + " of " + d.of + " segments" : "";
    $("view-h").textContent = title + ": " + end.toFixed(3) + " s" + part;
    $("speed-f").hidden = !d.profile;
    $("space-f").hidden = !d.path;
    legend(); table(); listing(); draw();
  };

  const KINDS = { joint: "blue", linear: "teal", circular: "olive", spline: "pink", wait: "orange", signal: "red" };
  const tone = (kind) => css(KINDS[kind] || "frame") || "#888";
  const legend = () => {
    $("legend").replaceChildren(...d.kinds.flatMap((kind) => {
      const key = document.createElement("i");
      key.className = "key"; key.style.background = tone(kind);
      return [key, kind];
    }));
  };

  const sized = (canvas) => {
    const box = canvas.getBoundingClientRect(), scale = devicePixelRatio || 1, height = +canvas.getAttribute("data-h") || +canvas.getAttribute("height");
    canvas.setAttribute("data-h", height);
    canvas.style.height = height + "px";
    canvas.width = Math.max(1, Math.round(box.width * scale));
    canvas.height = Math.round(height * scale);
    const pen = canvas.getContext("2d");
    pen.setTransform(scale, 0, 0, scale, 0, 0);
    pen.font = "11.5px system-ui, sans-serif";
    return [pen, box.width, height];
  };

  const ticks = (low, high, count) => {
    const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw || 1));
    const step = [1, 2, 5, 10].map((f) => f * power).find((s) => s >= raw) || raw;
    const found = [];
    for (let t = Math.ceil(low / step) * step; t <= high + step * 1e-9; t += step) found.push(+t.toPrecision(10));
    return found;
  };
  const LEFT = 58;

  const gantt = () => {
    const [pen, w, h] = sized($("gantt"));
    const kinds = d.kinds, high = (h - 22) / Math.max(1, kinds.length), span = to - from || 1;
    const x = (t) => LEFT + ((t - from) / span) * (w - LEFT - 6);
    pen.fillStyle = css("muted"); pen.strokeStyle = css("grid");
    pen.textAlign = "center";
    for (const t of ticks(from, to, w / 90)) {
      pen.beginPath(); pen.moveTo(x(t), 0); pen.lineTo(x(t), h - 20); pen.stroke();
      pen.fillText(t + " s", x(t), h - 6);
    }
    pen.textAlign = "right";
    kinds.forEach((kind, i) => pen.fillText(kind, LEFT - 6, i * high + high / 2 + 4));
    const drawn = kinds.map(() => -1e9);
    for (let step = 0; step < ends.length; step++) {
      if (ends[step] < from || begins[step] > to) continue;
      const k = d.kind[step], left = Math.max(LEFT, x(begins[step])), right = Math.min(w - 6, x(ends[step]));
      if (right - drawn[k] < 0.5 && step !== on) continue; // thinner than a pixel, and painted already
      drawn[k] = right;
      pen.fillStyle = tone(kinds[k]);
      pen.fillRect(left, k * high + 2, Math.max(0.8, right - left - (right - left > 3 ? 1 : 0)), high - 4);
    }
    if (on >= 0) {
      pen.strokeStyle = css("ink"); pen.lineWidth = 2;
      const k = d.kind[on];
      pen.strokeRect(Math.max(LEFT, x(begins[on])) - 1, k * high + 1, Math.max(2, x(ends[on]) - x(begins[on])) + 1, high - 2);
      pen.lineWidth = 1;
    }
  };

  const speed = () => {
    if (!d.profile) return;
    const [pen, w, h] = sized($("speed"));
    const values = d.profile.speed, end = d.profile.end, span = to - from || 1;
    const most = Math.max(1, ...values.map((v) => v || 0));
    const x = (t) => LEFT + ((t - from) / span) * (w - LEFT - 6), y = (v) => h - 20 - (v / most) * (h - 30);
    pen.strokeStyle = css("grid"); pen.fillStyle = css("muted");
    pen.textAlign = "right";
    for (const v of ticks(0, most, 4)) {
      pen.beginPath(); pen.moveTo(LEFT, y(v)); pen.lineTo(w - 6, y(v)); pen.stroke();
      pen.fillText(v, LEFT - 6, y(v) + 4);
    }
    pen.textAlign = "center";
    for (const t of ticks(from, to, w / 90)) pen.fillText(t + " s", x(t), h - 6);
    if (on >= 0) {
      pen.fillStyle = css("grid");
      pen.fillRect(x(begins[on]), 0, Math.max(1, x(ends[on]) - x(begins[on])), h - 20);
    }
    pen.strokeStyle = css("teal"); pen.lineWidth = 1.6; pen.beginPath();
    let open = false;
    values.forEach((v, i) => {
      const t = (i / (values.length - 1)) * end;
      if (v === null || t < from - span * 0.01 || t > to + span * 0.01) { open = false; return; }
      if (open) pen.lineTo(x(t), y(v)); else pen.moveTo(x(t), y(v));
      open = true;
    });
    pen.stroke();
    pen.lineWidth = 1;
  };

  let projected = [];
  const space = () => {
    if (!d.path) return;
    const [pen, w, h] = sized($("space"));
    const p = d.path, n = p.x.length;
    const middle = [p.x, p.y, p.z].map((v) => (v.reduce((a, b) => Math.min(a, b), Infinity) + v.reduce((a, b) => Math.max(a, b), -Infinity)) / 2);
    const reach = Math.max(1, ...[p.x, p.y, p.z].map((v, i) => v.reduce((a, b) => Math.max(a, Math.abs(b - middle[i])), 0)));
    const scale = (Math.min(w, h) / 2.6 / reach) * zoom, [ca, sa] = [Math.cos(turn[0]), Math.sin(turn[0])], [cb, sb] = [Math.cos(turn[1]), Math.sin(turn[1])];
    const at = (x, y, z) => {
      const a = x * ca - y * sa, b = x * sa + y * ca;
      return [w / 2 + a * scale, h / 2 - (z * cb + b * sb) * scale];
    };
    projected = [];
    for (let i = 0; i < n; i++) projected.push(at(p.x[i] - middle[0], p.y[i] - middle[1], p.z[i] - middle[2]));
    const low = dark() ? [70, 130, 220] : [20, 80, 160], high = dark() ? [255, 190, 110] : [190, 80, 10];
    const value = (step) => (colour === "time" ? d.seconds[step] || 0 : d.reached[step] || 0);
    const top = d.seconds.reduce((most, _, s) => Math.max(most, value(s)), 1e-9);
    pen.lineWidth = 1.8; pen.lineCap = "round";
    for (let i = 1; i < n; i++) {
      const share = Math.sqrt(Math.min(1, value(p.step[i]) / top));
      pen.strokeStyle = p.step[i] === on ? css("ink") : "rgb(" + low.map((c, k) => Math.round(c + (high[k] - c) * share)).join(",") + ")";
      pen.lineWidth = p.step[i] === on ? 4 : 1.8;
      pen.beginPath(); pen.moveTo(...projected[i - 1]); pen.lineTo(...projected[i]); pen.stroke();
    }
    const axis = [["X", 1, 0, 0], ["Y", 0, 1, 0], ["Z", 0, 0, 1]];
    pen.lineWidth = 1; pen.strokeStyle = pen.fillStyle = css("muted"); pen.textAlign = "center";
    for (const [name, x, y, z] of axis) {
      const a = x * ca - y * sa, b = x * sa + y * ca, ex = 34 + a * 24, ey = h - 34 - (z * cb + b * sb) * 24;
      pen.beginPath(); pen.moveTo(34, h - 34); pen.lineTo(ex, ey); pen.stroke();
      pen.fillText(name, 34 + a * 32, h - 30 - (z * cb + b * sb) * 32);
    }
    pen.textAlign = "left";
    const unit = colour === "time" ? " s" : " mm/s", bar = w - 150;
    for (let i = 0; i < 100; i++) {
      pen.fillStyle = "rgb(" + low.map((c, k) => Math.round(c + (high[k] - c) * (i / 100))).join(",") + ")";
      pen.fillRect(bar + i, 10, 1.5, 8);
    }
    pen.fillStyle = css("muted");
    pen.fillText("0", bar, 32); pen.textAlign = "right";
    pen.fillText((top >= 10 ? top.toFixed(0) : top.toFixed(2)) + unit, bar + 104, 32);
  };

  const draw = () => { if (!d) return; gantt(); speed(); space(); };

  // Chosen by the reader: an editor goes there, too.
  const pick = (step, scroll) => {
    choose(step, scroll);
    if (editor && on === step) editor.postMessage({ file: d.file[step], line: d.line[step] });
  };

  // The chosen segment, in every picture.
  const choose = (step, scroll) => {
    if (!d || step < 0 || step >= ends.length) return;
    on = step;
    const percent = d.percent[step];
    const facts = [
      ["line", d.line[step] + (d.file[step] ? " of " + (d.files.find((f) => f.index === d.file[step]) || {}).name : "")],
      ["statement", text(step)],
      ["kind", d.kinds[d.kind[step]]],
      ["from", begins[step].toFixed(3) + " s"],
      ["takes", d.seconds[step] === null ? "not known" : d.seconds[step].toFixed(3) + " s"],
      ["95 % interval", d.low && d.low[step] !== null ? d.low[step].toFixed(3) + " to " + d.high[step].toFixed(3) + " s" : ""],
      ["limited by", d.rules[d.rule[step]]],
      ["way", d.mm[step] === null ? "" : d.mm[step] + " mm"],
      ["programmed", percent !== null ? percent + " %" : d.speed[step] === null ? "" : d.speed[step] + " mm/s"],
      ["reached", d.reached[step] === null ? "" : d.reached[step] + " mm/s"],
      ["acceleration", d.accel[step] === null ? "" : d.accel[step] + " mm/s²"],
    ];
    $("facts").replaceChildren(...facts.filter(([, value]) => value !== "").flatMap(([name, value]) => {
      const dt = document.createElement("dt"), dd = document.createElement("dd");
      dt.textContent = name; dd.textContent = value;
      return [dt, dd];
    }));
    $("told").textContent = "line " + d.line[step] + ": " + (d.seconds[step] === null ? "not known" : d.seconds[step].toFixed(3) + " s");
    for (const old of document.querySelectorAll("#view .on")) old.classList.remove("on");
    const row = document.querySelector('#segments tr[data-step="' + step + '"]');
    const line = document.querySelector('#text div[data-at="' + d.file[step] + ":" + d.line[step] + '"]');
    for (const mark of [row, line]) if (mark) mark.classList.add("on");
    if (scroll) for (const [mark, box] of [[row, $("segments").parentElement], [line, $("text")]])
      if (mark && mark.parentElement) box.scrollTop = mark.offsetTop - box.offsetTop - box.clientHeight / 2;
    draw();
  };

  // The table: sorted and searched in the data, made in pieces.
  const keys = [(s) => d.line[s], text, (s) => d.kinds[d.kind[s]], (s) => d.mm[s], (s) => d.speed[s] ?? d.percent[s], (s) => d.reached[s], (s) => d.rules[d.rule[s]], (s) => d.seconds[s], (s) => ends[s]];
  const table = () => {
    const words = $("search").value.toLowerCase().split(/\s+/).filter(Boolean);
    const kept = words.length ? order.filter((s) => {
      const all = (text(s) + " " + d.kinds[d.kind[s]] + " " + d.rules[d.rule[s]]).toLowerCase();
      return words.every((word) => (/^\d+$/.test(word) && String(d.line[s]) === word) || all.includes(word));
    }) : order;
    const body = document.createElement("tbody");
    for (const s of kept.slice(0, rows)) {
      const row = body.insertRow();
      row.dataset.step = s;
      if (s === on) row.className = "on";
      const v = d.percent[s] !== null ? d.percent[s] + " %" : fixed(d.speed[s], 1);
      [d.line[s], text(s), d.kinds[d.kind[s]], fixed(d.mm[s], 1), v, fixed(d.reached[s], 0), d.rules[d.rule[s]], d.seconds[s] === null ? "unknown" : d.seconds[s].toFixed(3), ends[s].toFixed(3)].forEach((value, i) => {
        const cell = row.insertCell();
        cell.textContent = value;
        if (i === 3 || i === 4 || i === 5 || i > 6) cell.className = "r";
      });
    }
    $("segments").tBodies[0].replaceWith(body);
    $("more").hidden = kept.length <= rows;
    $("count").textContent = kept.length + " of " + order.length + " segments" + (kept.length > rows ? ", the first " + rows + " shown" : "");
  };

  const listing = () => {
    if (editor) return; // the text stands beside it
    sums = {};
    const first = {};
    d.seconds.forEach((seconds, step) => {
      const key = d.file[step] + ":" + d.line[step];
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
    const last = { d, on, from, to, zoom, end: ends[ends.length - 1] || 1, words: $("search").value };
    show(data, title);
    if (!d || !last.d) return;
    const end = ends[ends.length - 1] || 1;
    zoom = last.zoom;
    if (last.from > 0 || last.to < last.end) { to = Math.min(end, last.to); from = Math.max(0, Math.min(last.from, to - 1e-3)); }
    if (last.words) { $("search").value = last.words; table(); }
    if (last.on >= 0) {
      const file = last.d.file[last.on], line = last.d.line[last.on], now = runsOf(d, file, line);
      if (now.length) choose(now[Math.min(runsOf(last.d, file, line).indexOf(last.on), now.length - 1)], false);
      else $("facts").replaceChildren();
    }
    draw();
  };
  const runsOf = (data, file, line) => data.line.flatMap((l, step) => (l === line && data.file[step] === file ? [step] : []));

  // The first run of a line, unless another run of it is chosen already; a line that takes no time changes nothing.
  const goTo = (file, line) => {
    if (!d || (on >= 0 && d.file[on] === file && d.line[on] === line)) return;
    const [step] = runsOf(d, file, line), span = to - from;
    if (step === undefined) return;
    if (begins[step] < from || ends[step] > to) {
      from = Math.max(0, Math.min((ends[ends.length - 1] || 1) - span, (begins[step] + ends[step] - span) / 2));
      to = from + span;
    }
    choose(step, true);
  };

  // Hands on.
  const zoomTime = (factor, centre) => {
    const end = ends[ends.length - 1] || 1, span = Math.min(end, Math.max(1e-3, (to - from) * factor));
    from = Math.max(0, Math.min(end - span, centre - (centre - from) * (span / (to - from))));
    to = from + span;
    draw();
  };
  const timeAt = (canvas, event) => {
    const box = canvas.getBoundingClientRect();
    return from + ((event.clientX - box.left - LEFT) / (box.width - LEFT - 6)) * (to - from);
  };
  const stepAt = (t) => {
    let low = 0, high = ends.length - 1;
    while (low < high) { const mid = (low + high) >> 1; if (ends[mid] < t) low = mid + 1; else high = mid; }
    return low;
  };
  for (const name of ["gantt", "speed"]) {
    const canvas = $(name);
    let dragged = null;
    canvas.addEventListener("pointerdown", (e) => { dragged = [e.clientX, from, to, false]; canvas.setPointerCapture(e.pointerId); });
    canvas.addEventListener("pointermove", (e) => {
      if (!dragged || !d) return;
      const way = ((e.clientX - dragged[0]) / (canvas.clientWidth - LEFT - 6)) * (dragged[2] - dragged[1]);
      if (Math.abs(e.clientX - dragged[0]) > 3) dragged[3] = true;
      const end = ends[ends.length - 1] || 1, span = dragged[2] - dragged[1];
      from = Math.max(0, Math.min(end - span, dragged[1] - way)); to = from + span;
      draw();
    });
    canvas.addEventListener("pointerup", (e) => {
      if (dragged && !dragged[3] && d) pick(stepAt(timeAt(canvas, e)), true);
      dragged = null;
    });
    canvas.addEventListener("wheel", (e) => { e.preventDefault(); zoomTime(e.deltaY > 0 ? 1.25 : 0.8, timeAt(canvas, e)); }, { passive: false });
  }
  $("gantt").addEventListener("keydown", (e) => {
    if (!d) return;
    const centre = on >= 0 ? begins[on] : (from + to) / 2;
    if (e.key === "ArrowRight") pick(Math.min(ends.length - 1, on + 1), true);
    else if (e.key === "ArrowLeft") pick(Math.max(0, on - 1), true);
    else if (e.key === "+") zoomTime(0.7, centre);
    else if (e.key === "-") zoomTime(1.4, centre);
    else if (e.key === "0") { from = 0; to = ends[ends.length - 1] || 1; draw(); }
    else return;
    e.preventDefault();
  });
  const canvas = $("space");
  let grip = null;
  canvas.addEventListener("pointerdown", (e) => { grip = [e.clientX, e.clientY, ...turn, false]; canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener("pointermove", (e) => {
    if (!grip) return;
    const [x, y] = [e.clientX - grip[0], e.clientY - grip[1]];
    if (Math.abs(x) + Math.abs(y) > 3) grip[4] = true;
    turn = [grip[2] + x / 150, Math.max(-1.57, Math.min(1.57, grip[3] + y / 150))];
    space();
  });
  canvas.addEventListener("pointerup", (e) => {
    if (grip && !grip[4] && d) {
      const box = canvas.getBoundingClientRect(), px = e.clientX - box.left, py = e.clientY - box.top;
      let best = -1, least = 400;
      for (let i = 1; i < projected.length; i++) {
        const [ax, ay] = projected[i - 1], [bx, by] = projected[i], l = (bx - ax) ** 2 + (by - ay) ** 2;
        const t = l ? Math.max(0, Math.min(1, ((px - ax) * (bx - ax) + (py - ay) * (by - ay)) / l)) : 0;
        const far = (ax + t * (bx - ax) - px) ** 2 + (ay + t * (by - ay) - py) ** 2;
        if (far < least) { least = far; best = d.path.step[i]; }
      }
      if (best >= 0) pick(best, true);
    }
    grip = null;
  });
  canvas.addEventListener("wheel", (e) => { e.preventDefault(); zoom = Math.max(0.2, Math.min(50, zoom * (e.deltaY > 0 ? 0.85 : 1.18))); space(); }, { passive: false });
  canvas.addEventListener("keydown", (e) => {
    const keysOf = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
    if (keysOf[e.key]) { turn = [turn[0] + keysOf[e.key][0], Math.max(-1.57, Math.min(1.57, turn[1] + keysOf[e.key][1]))]; }
    else if (e.key === "+") zoom *= 1.2; else if (e.key === "-") zoom /= 1.2; else return;
    e.preventDefault(); space();
  });
  for (const button of document.querySelectorAll("[data-colour]")) button.addEventListener("click", () => {
    colour = button.dataset.colour;
    for (const other of document.querySelectorAll("[data-colour]")) other.setAttribute("aria-pressed", other === button);
    space();
  });
  $("segments").addEventListener("click", (e) => {
    const row = e.target.closest("tr[data-step]");
    if (row) pick(+row.dataset.step, false);
  });
  $("text").addEventListener("click", (e) => {
    const row = e.target.closest("div[data-step]");
    if (row) pick(+row.dataset.step, true);
  });
  $("search").addEventListener("input", () => { rows = PAGE; table(); });
  $("more").addEventListener("click", () => { rows += 2000; table(); });
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
    rows = PAGE; table();
  });
  sortable($("index"), (column, sign) => {
    const body = $("index").tBodies[0];
    const found = [...body.rows].map((row) => {
      const cell = row.cells[column].textContent, value = parseFloat(cell);
      return [row.cells[column].className.startsWith("r") ? (isNaN(value) ? null : value) : cell, row];
    });
    body.append(...found.sort(by(sign)).map(([, row]) => row));
  });

  $("theme").hidden = false;
  $("theme").addEventListener("click", () => { root.dataset.theme = dark() ? "light" : "dark"; if (d) { legend(); draw(); } });
  matchMedia("(prefers-color-scheme:dark)").addEventListener("change", draw);
  addEventListener("resize", draw);
  addEventListener("beforeprint", () => { root.dataset.theme = "light"; draw(); });
  const longest = +document.body.dataset.first;
  const follow = () => { const match = /^#p(\d+)$/.exec(location.hash); open(match ? +match[1] : longest); };
  addEventListener("hashchange", () => { follow(); $("view").scrollIntoView(); });
  follow();
  if (editor) {
    const themed = () => {
      root.dataset.theme = (document.body.dataset.vscodeThemeKind || "").includes("light") ? "light" : "dark";
      if (d) { legend(); draw(); }
    };
    new MutationObserver(themed).observe(document.body, { attributes: true, attributeFilter: ["data-vscode-theme-kind", "data-vscode-theme-id"] });
    themed();
    addEventListener("message", ({ data: said }) => {
      if (said.program) renew(said.program.data, said.program.title);
      if (said.select) goTo(said.select.file, said.select.line);
    });
    editor.postMessage({ ready: true });
  }
  root.dataset.ready = Math.round(performance.now());
})();
