"use strict";
(() => {
  const $ = (id) => document.getElementById(id);
  const data = JSON.parse($("data").textContent);
  const root = document.documentElement;
  const number = (text) => parseFloat(text.replace("\u2212", "-").replace(/[^-0-9.]/g, ""));
  const ms = (value) => (value === null ? "not known" : value.toFixed(1).replace("-", "\u2212") + " ms");

  // Theme: the system's until the reader chooses.
  const dark = () => (root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme:dark)").matches);
  $("theme").hidden = false;
  $("theme").addEventListener("click", () => {
    root.dataset.theme = dark() ? "light" : "dark";
    draw();
  });

  // What is at the pointer.
  const tip = $("tip");
  const show = (event, row) => {
    const after = data.found ? "\nwith the causes " + ms(data.after[row]) : "";
    tip.textContent = data.names[row] + "\nrobot minus simulation " + ms(data.before[row]) + after;
    tip.hidden = false;
    const box = tip.getBoundingClientRect();
    tip.style.left = Math.max(4, Math.min(event.clientX + 14, innerWidth - box.width - 8)) + "px";
    tip.style.top = Math.max(4, event.clientY - box.height - 12) + "px";
  };
  const hide = () => { tip.hidden = true; };
  const nearest = (points, x, y, reach) => {
    let best = -1, least = reach * reach;
    for (const [px, py, row] of points) {
      const far = (px - x) ** 2 + (py - y) ** 2;
      if (far < least) { least = far; best = row; }
    }
    return best;
  };
  const go = (row) => {
    const line = $("move-" + data.names[row].split(",")[0].slice(5));
    if (!line) return;
    for (const old of document.querySelectorAll(".found")) old.classList.remove("found");
    line.hidden = false;
    line.classList.add("found");
    line.scrollIntoView({ block: "center" });
  };
  for (const picture of document.querySelectorAll("svg")) {
    const points = [];
    for (const path of picture.querySelectorAll("path[data-rows]")) {
      const rows = path.dataset.rows.split(" ");
      path.getAttribute("d").slice(1).split("M").forEach((text, i) => {
        const [x, y] = text.replace(/h.*/, "").split(" ").map(Number);
        points.push([x, y, +rows[i]]);
      });
    }
    if (!points.length) continue;
    const at = (event) => {
      const box = picture.getBoundingClientRect(), scale = picture.viewBox.baseVal.width / box.width;
      return nearest(points, (event.clientX - box.left) * scale, (event.clientY - box.top) * scale, 12);
    };
    picture.addEventListener("pointermove", (event) => {
      const row = at(event);
      picture.style.cursor = row < 0 ? "" : "pointer";
      if (row < 0) hide(); else show(event, row);
    });
    picture.addEventListener("pointerleave", hide);
    picture.addEventListener("click", (event) => { const row = at(event); if (row >= 0) go(row); });
  }

  // A link to a line in a folded listing opens it.
  const unfold = () => {
    const line = location.hash.length > 1 && $(location.hash.slice(1)), fold = line && line.closest("details");
    if (fold && !fold.open) { fold.open = true; line.scrollIntoView(); }
  };
  addEventListener("hashchange", unfold);
  unfold();

  // Tables: sorted by a click on a heading.
  for (const table of document.querySelectorAll("table.sortable")) {
    const heads = [...table.tHead.rows[0].cells];
    heads.forEach((head, column) => {
      const button = document.createElement("button");
      button.type = "button";
      button.append(...head.childNodes);
      head.append(button);
      button.addEventListener("click", () => {
        const down = head.getAttribute("aria-sort") === "descending";
        heads.forEach((other) => other.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", down ? "ascending" : "descending");
        const body = table.tBodies[0], sign = down ? 1 : -1;
        const keyed = [...body.rows].map((row) => {
          const text = row.cells[column].textContent, value = number(text) * (/\d s$/.test(text) ? 1000 : 1);
          return [head.className === "r" && !isNaN(value) ? value : text, row];
        });
        keyed.sort(([a], [b]) => sign * (typeof a === "number" && typeof b === "number"
          ? a - b : String(a).localeCompare(String(b), "en", { numeric: true })));
        body.append(...keyed.map(([, row]) => row));
      });
    });
  }

  // The ledger: only some rows.
  const book = $("book"), search = $("search"), only = $("only");
  const filter = () => {
    const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
    let shown = 0;
    for (const row of book.tBodies[0].rows) {
      const place = row.cells[1].textContent.toLowerCase();
      const keep = (!only.checked || row.lastElementChild.textContent !== "") &&
        words.every((word) => (/^\d+$/.test(word) ? row.cells[0].textContent === word || place.endsWith(":" + word) : place.includes(word)));
      row.hidden = !keep;
      shown += keep;
    }
    $("count").textContent = shown + " of " + book.tBodies[0].rows.length + " moves";
  };
  if (book) {
    document.querySelector(".tools").hidden = false;
    search.addEventListener("input", filter);
    only.addEventListener("change", filter);
  }

  // The path in space: turned by drag or keys, far moves drawn first.
  const canvas = $("view");
  let draw = () => {};
  if (canvas && data.ways.length) {
    const pen = canvas.getContext("2d"), ways = data.ways;
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    for (const way of ways) {
      for (let k = 0; k < 6; k++) {
        low[k % 3] = Math.min(low[k % 3], way[k + 1]);
        high[k % 3] = Math.max(high[k % 3], way[k + 1]);
      }
    }
    const mid = low.map((value, k) => (value + high[k]) / 2);
    const size = Math.max(1, Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]));
    const first = { turn: -0.7, tilt: 0.5, zoom: 1 };
    const flat = (p, to) => {
      const x = p[0] - mid[0], y = p[1] - mid[1], z = p[2] - mid[2];
      const c = Math.cos(to.turn), s = Math.sin(to.turn), ct = Math.cos(to.tilt), st = Math.sin(to.tilt);
      return [c * x - s * y, ct * z + st * (s * x + c * y), ct * (s * x + c * y) - st * z];
    };
    // The first view fills the picture.
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((i) => flat([0, 1, 2].map((k) => ((i >> k) & 1 ? high : low)[k]), first));
    const reach = [0, 1].map((k) => Math.max(1, ...corners.map((corner) => Math.abs(corner[k]))));
    let look = { ...first }, after = false, spots = [], drag = null, width = 960, height = 460;
    const project = (p) => {
      const [right, up, deep] = flat(p, look);
      const k = look.zoom * 0.42 * Math.min(width / reach[0], height / reach[1]);
      return [width / 2 + k * right, height / 2 - k * up, deep];
    };
    const stroke = (a, b, colour, wide) => {
      pen.strokeStyle = colour;
      pen.lineWidth = wide;
      pen.beginPath();
      pen.moveTo(a[0], a[1]);
      pen.lineTo(b[0], b[1]);
      pen.stroke();
    };
    const round = (value) => { const p = 10 ** Math.floor(Math.log10(value)); return [1, 2, 5, 10].map((f) => f * p).find((v) => v >= value); };
    const floor = (tone) => {
      const step = round(size / 8), z = low[2];
      const from = [0, 1].map((k) => Math.floor(low[k] / step) * step), to = [0, 1].map((k) => Math.ceil(high[k] / step) * step);
      for (let x = from[0]; x <= to[0]; x += step) stroke(project([x, from[1], z]), project([x, to[1], z]), tone("grid"), 1);
      for (let y = from[1]; y <= to[1]; y += step) stroke(project([from[0], y, z]), project([to[0], y, z]), tone("grid"), 1);
      pen.fillStyle = tone("muted");
      pen.font = "12px system-ui, sans-serif";
      pen.fillText("squares of " + step + " mm", 12, height - 12);
      const o = [from[0], from[1], z];
      ["X", "Y", "Z"].forEach((name, k) => {
        const tipOf = o.slice();
        tipOf[k] += step * 1.2;
        const a = project(o), b = project(tipOf);
        stroke(a, b, tone("ink"), 2);
        pen.fillStyle = tone("ink");
        pen.fillText(name, b[0] + 5, b[1] - 4);
      });
    };
    draw = () => {
      const style = getComputedStyle(root), tone = (name) => style.getPropertyValue("--" + name).trim();
      const ratio = window.devicePixelRatio || 1;
      width = canvas.clientWidth || 960;
      height = Math.max(300, Math.round(width * 0.48));
      canvas.width = width * ratio;
      canvas.height = height * ratio;
      canvas.style.height = height + "px";
      pen.setTransform(ratio, 0, 0, ratio, 0, 0);
      pen.clearRect(0, 0, width, height);
      floor(tone);
      const values = after ? data.after : data.before;
      const drawn = ways.map((way) => {
        const a = project(way.slice(1, 4)), b = project(way.slice(4, 7)), value = values[way[0]] || 0;
        const step = Math.max(0, Math.min(8, Math.round(value / data.limit * 4) + 4));
        return { a, b, step, row: way[0], deep: a[2] + b[2] };
      }).sort((one, two) => two.deep - one.deep);
      pen.lineCap = "round";
      spots = [];
      for (const { a, b, step, row } of drawn) {
        stroke(a, b, tone("r" + step), Math.abs(step - 4) > 2 ? 2.6 : 1.7);
        for (const t of [0.25, 0.5, 0.75]) spots.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), row]);
        spots.push([b[0], b[1], row]);
      }
    };
    const choose = (value) => {
      after = value && data.found;
      $("show-before").setAttribute("aria-pressed", String(!after));
      if ($("show-after")) $("show-after").setAttribute("aria-pressed", String(after));
      draw();
    };
    $("show-before").addEventListener("click", () => choose(false));
    if ($("show-after")) $("show-after").addEventListener("click", () => choose(true));
    canvas.addEventListener("keydown", (event) => {
      const keys = {
        ArrowLeft: () => { look.turn -= 0.12; }, ArrowRight: () => { look.turn += 0.12; },
        ArrowUp: () => { look.tilt = Math.min(1.57, look.tilt + 0.1); }, ArrowDown: () => { look.tilt = Math.max(-1.57, look.tilt - 0.1); },
        "+": () => { look.zoom *= 1.2; }, "=": () => { look.zoom *= 1.2; }, "-": () => { look.zoom /= 1.2; },
        0: () => { look = { ...first }; }, b: () => choose(!after),
      };
      if (!keys[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      keys[event.key]();
      draw();
    });
    canvas.addEventListener("pointerdown", (event) => {
      drag = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!drag) {
        const box = canvas.getBoundingClientRect();
        const row = nearest(spots, event.clientX - box.left, event.clientY - box.top, 14);
        if (row < 0) hide(); else show(event, row);
        return;
      }
      hide();
      look.turn += (event.clientX - drag[0]) * 0.008;
      look.tilt = Math.max(-1.57, Math.min(1.57, look.tilt + (event.clientY - drag[1]) * 0.008));
      drag = [event.clientX, event.clientY];
      draw();
    });
    for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, () => { drag = null; });
    canvas.addEventListener("pointerleave", hide);
    $("space").hidden = false;
    addEventListener("resize", draw);
    matchMedia("(prefers-color-scheme:dark)").addEventListener("change", () => draw());
    let chosen;
    addEventListener("beforeprint", () => { chosen = root.dataset.theme; root.dataset.theme = "light"; draw(); });
    addEventListener("afterprint", () => { if (chosen) root.dataset.theme = chosen; else delete root.dataset.theme; draw(); });
    draw();
  }
})();
