"use strict";
// Segments, speed and axes over one time axis, drawn by uPlot: the wheel or a drag zooms, a double click shows all.
const makeCharts = (page) => {
  const { uPlot } = libraries;
  const LEFT = 62; // px of the vertical axes, so that all charts agree about the time
  const LEAST = 1e-3; // s that a chart shows at least
  let shown = null, plots = [], view = [0, 1], now = 0, chosen = -1;

  const end = () => shown.end || 1;
  const seconds = (t) => +t.toPrecision(6) + " s";

  /** Shows from..to [s] in every chart. */
  const look = (from, to) => {
    const span = Math.min(end(), Math.max(LEAST, to - from));
    const begin = Math.max(0, Math.min(end() - span, from));
    view = [begin, begin + span];
    for (const { plot } of plots) plot.setScale("x", { min: view[0], max: view[1] });
  };
  const zoom = (factor, centre = (view[0] + view[1]) / 2) =>
    look(centre - (centre - view[0]) * factor, centre + (view[1] - centre) * factor);
  const pan = (share) => look(view[0] + share * (view[1] - view[0]), view[1] + share * (view[1] - view[0]));

  const axis = (more) => ({
    stroke: () => page.css("muted"),
    font: "12px system-ui, sans-serif",
    grid: { stroke: () => page.css("grid"), width: 1 },
    ticks: { stroke: () => page.css("grid"), width: 1, size: 4 },
    ...more,
  });

  /** One chart in the element `id`. `hover(time, event, plot)`: the step under the pointer and what to say of it. */
  const chart = (id, data, series, y, hover, draw) => {
    const box = page.$(id), height = +box.dataset.height;
    const plot = new uPlot({
      width: Math.max(200, box.clientWidth),
      height,
      padding: [8, 10, 0, 0],
      legend: { show: false },
      cursor: { y: false, points: { show: series.length > 1 && id !== "gantt", size: 7 }, sync: { key: "olp" }, drag: { x: true, y: false } },
      scales: { x: { time: false, range: (_, min, max) => [min, max] }, y: { range: y.range } },
      axes: [
        axis({ values: (_, ticks) => ticks.map(seconds), space: 80, size: 30 }),
        axis({ size: LEFT, gap: 4, ...y.axis }),
      ],
      series: [{}, ...series],
      hooks: {
        draw: draw ? [draw, () => place()] : [() => place()],
        setScale: [(u, key) => {
          const { min, max } = u.scales.x;
          if (key === "x" && (min !== view[0] || max !== view[1])) look(min, max);
        }],
      },
    }, data, box);
    const marks = { chosen: document.createElement("div"), now: document.createElement("div") };
    for (const [name, mark] of Object.entries(marks)) { mark.className = "mark-" + name; plot.over.append(mark); }
    const { over } = plot;
    let pressed = 0;
    const found = (e) => hover(plot.posToVal(e.clientX - over.getBoundingClientRect().left, "x"), e, plot);
    over.addEventListener("mousedown", (e) => { pressed = e.clientX; });
    over.addEventListener("click", (e) => {
      if (Math.abs(e.clientX - pressed) > 3) return;
      const { step, time } = found(e);
      if (step >= 0) page.pick(step, time);
    });
    over.addEventListener("mousemove", (e) => page.tip(e, found(e).says));
    over.addEventListener("mouseleave", () => page.tip(null));
    over.addEventListener("wheel", (e) => {
      e.preventDefault();
      if (e.shiftKey || Math.abs(e.deltaX) > Math.abs(e.deltaY)) pan(0.1 * Math.sign(e.deltaX || e.deltaY));
      else zoom(e.deltaY > 0 ? 1.25 : 0.8, plot.posToVal(e.clientX - over.getBoundingClientRect().left, "x"));
    }, { passive: false });
    plots.push({ plot, box, height, marks, id });
  };

  /** The marks of the chosen segment and of the playback's instant. */
  const place = () => {
    const { begins, ends, d } = shown;
    for (const { plot, marks, id } of plots) {
      const x = (t) => plot.valToPos(t, "x"), width = plot.over.clientWidth;
      const at = x(now);
      marks.now.hidden = !(at >= 0 && at <= width);
      marks.now.style.left = at + "px";
      const left = Math.max(-2, chosen < 0 ? 0 : x(begins[chosen])), right = Math.min(width + 2, chosen < 0 ? -1 : x(ends[chosen]));
      marks.chosen.hidden = right < left;
      marks.chosen.style.left = left - 1 + "px";
      marks.chosen.style.width = Math.max(3, right - left + 2) + "px";
      if (id !== "gantt" || chosen < 0) continue;
      const top = plot.valToPos(d.kinds.length - d.kind[chosen], "y"), bottom = plot.valToPos(d.kinds.length - d.kind[chosen] - 1, "y");
      marks.chosen.style.top = top + "px";
      marks.chosen.style.height = bottom - top + "px";
    }
  };

  const boxes = (u) => {
    const { ctx, bbox } = u, { d, begins, ends } = shown, count = d.kinds.length;
    const { min, max } = u.scales.x, unit = devicePixelRatio || 1, high = bbox.height / Math.max(1, count);
    const x = (t) => bbox.left + ((t - min) / (max - min)) * bbox.width;
    const tones = d.kinds.map(page.tone), drawn = d.kinds.map(() => -1e9);
    ctx.save();
    ctx.beginPath(); ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height); ctx.clip();
    for (let step = 0; step < ends.length; step++) {
      if (ends[step] < min || begins[step] > max) continue;
      const k = d.kind[step], left = Math.max(bbox.left, x(begins[step])), right = Math.min(bbox.left + bbox.width, x(ends[step]));
      if (right - drawn[k] < 0.5 * unit) continue; // thinner than a pixel, and painted already
      drawn[k] = right;
      const wide = right - left;
      ctx.fillStyle = tones[k];
      ctx.fillRect(left, bbox.top + k * high + 2 * unit, Math.max(unit, wide > 3 * unit ? wide - unit : wide), high - 4 * unit);
    }
    ctx.restore();
  };

  /** The segment under the pointer: that of the row, where one of its kind is near enough to be meant. */
  const inGantt = (time, e, plot) => {
    const { d, begins, ends } = shown, box = plot.over.getBoundingClientRect();
    const row = Math.floor(((e.clientY - box.top) / box.height) * d.kinds.length);
    const near = 5 * (view[1] - view[0]) / box.width, here = shown.stepAt(time);
    let step = here, least = Infinity;
    for (const way of [-1, 1])
      for (let s = here; s >= 0 && s < ends.length; s += way) {
        const far = Math.max(begins[s] - time, time - ends[s], 0);
        if (far > near) break;
        if (d.kind[s] === row && far < least) { least = far; step = s; }
      }
    return { step, time: undefined, says: page.describe(step) };
  };

  const valueAt = (times, values, time) => {
    const i = page.before(times, time), j = Math.min(i + 1, times.length - 1);
    if (values[i] === null || values[j] === null) return null;
    const share = times[j] > times[i] ? (time - times[i]) / (times[j] - times[i]) : 0;
    return values[i] + (values[j] - values[i]) * Math.min(1, Math.max(0, share));
  };
  const tones = () => ["blue", "teal", "orange", "pink", "olive", "red", "muted"].map((name) => page.css(name));

  const show = (next, keep = false) => {
    for (const { plot } of plots) plot.destroy();
    plots = [];
    shown = next;
    if (!keep) { chosen = -1; now = 0; view = [0, end()]; }
    const { d } = shown, whole = [0, end()], count = d.kinds.length;
    chart("gantt", [whole, [null, null]], [{ paths: () => null, points: { show: false } }], {
      range: () => [0, count],
      axis: { splits: () => d.kinds.map((_, k) => count - k - 0.5), values: () => d.kinds, grid: { show: false }, ticks: { show: false } },
    }, inGantt, boxes);
    if (d.profile) {
      const { speed } = d.profile, most = speed.reduce((a, v) => Math.max(a, v || 0), 1) * 1.06;
      const times = speed.map((_, i) => (i / (speed.length - 1)) * d.profile.end);
      chart("speed", [times, speed], [{ stroke: () => page.css("teal"), width: 1.6, points: { show: false }, fill: () => page.css("teal") + "22" }], { range: () => [0, most] },
        (time) => {
          const v = valueAt(times, speed, time), step = shown.stepAt(time);
          return { step, time, says: [time.toFixed(3) + " s", v === null ? "" : v.toFixed(0) + " mm/s", ...page.describe(step, true)] };
        });
    }
    if (d.arm) {
      const all = d.arm.axes.flat().filter((v) => v !== null);
      const low = all.reduce((a, b) => Math.min(a, b), 0), high = all.reduce((a, b) => Math.max(a, b), 1), room = (high - low) * 0.05;
      const colours = tones();
      chart("axes", [d.arm.t, ...d.arm.axes], d.arm.names.map((name, i) => ({ label: name, stroke: colours[i % colours.length], width: 1.4, points: { show: false } })), { range: () => [low - room, high + room] },
        (time) => {
          const step = shown.stepAt(time);
          const values = d.arm.names.map((name, i) => {
            const v = valueAt(d.arm.t, d.arm.axes[i], time);
            return name + " " + (v === null ? "not known" : v.toFixed(1) + (d.arm.linear[i] ? " mm" : "°"));
          });
          return { step, time, says: [time.toFixed(3) + " s", values.join(", "), ...page.describe(step, true)] };
        });
      page.key("axes-key", d.arm.names.map((name, i) => [name, colours[i % colours.length]]));
    }
    look(...view);
    place();
  };

  const resize = (width) => {
    for (const { plot, box, height } of plots) {
      const wide = Math.max(200, width || box.clientWidth);
      if (wide !== plot.width) plot.setSize({ width: wide, height });
    }
  };
  return {
    show, resize, zoom, pan, look,
    get view() { return view; },
    choose: (step) => { chosen = step; place(); },
    /** The playback's instant [s]; a zoomed view goes along. */
    at: (time) => {
      now = time;
      if (time < view[0] || time > view[1]) look(time, time + view[1] - view[0]); else place();
    },
  };
};
