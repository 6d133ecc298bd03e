"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const decoded = new Map();
  const printing = matchMedia("print");
  let live = [];

  // Little-endian f32 in base64; gaps are NaN there and null for the plotter.
  function array(index) {
    if (!decoded.has(index)) {
      const bytes = Uint8Array.from(atob(data.arrays[index]), (c) => c.charCodeAt(0));
      const view = new DataView(bytes.buffer);
      const values = Array.from({ length: bytes.length / 4 }, (_, i) => view.getFloat32(4 * i, true));
      decoded.set(index, values.map((v) => (Number.isNaN(v) ? null : v)));
    }
    return decoded.get(index);
  }

  const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const shown = (v) => (v == null ? "–" : String(Number(v.toPrecision(5))));
  // Ten colours, then the same ten dashed.
  const look = (i) => ({ stroke: style(`--c${i % 10}`), width: 1.5, dash: i < 10 ? undefined : [6, 3] });

  function axis(label, size) {
    return {
      label, size, labelSize: 18, gap: 3, font: "11px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif",
      stroke: style("--muted"), grid: { stroke: style("--grid"), width: 1 }, ticks: { stroke: style("--grid"), width: 1 },
      values: (u, splits) => splits.map((v) => (v == null ? "" : shown(v))),
    };
  }

  const frame = (plot, box) => ({
    width: box.clientWidth,
    axes: [axis(plot.x, 30), axis(plot.y, 56)],
    cursor: { drag: { x: true, y: true, uni: 30 }, points: { size: 6 } },
  });

  function functions(plot, box) {
    const options = {
      ...frame(plot, box),
      height: 250,
      scales: { x: { time: false } },
      series: [
        { label: plot.x, value: (u, v) => shown(v) },
        ...plot.names.map((label, i) => ({ label, ...look(i), points: { show: false }, value: (u, v) => shown(v) })),
      ],
    };
    // The cursor shows the same abscissa in all plots that share it.
    options.cursor.sync = { key: `x${plot.arrays[0]}` };
    return new uPlot(options, plot.arrays.map(array), box);
  }

  // Ranges that make a unit equally long on both axes of a plotting area of w by h pixels.
  function equalRanges(plot, w, h) {
    const extent = (k) => {
      const all = plot.arrays.flatMap((pair) => array(pair[k])).filter((v) => v != null);
      return all.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
    };
    const [x, y] = [extent(0), extent(1)];
    if (!(x[0] <= x[1])) return [[-1, 1], [-1, 1]];
    const span = Math.max((x[1] - x[0]) / w, (y[1] - y[0]) / h) * 1.1 || 1 / h;
    const about = ([a, b], size) => [(a + b - span * size) / 2, (a + b + span * size) / 2];
    return [about(x, w), about(y, h)];
  }

  function nearest(u, pair) {
    const { left, top } = u.cursor;
    if (left < 0) return null;
    const [xs, ys] = pair.map(array);
    let best = null, least = Infinity;
    for (let i = 0; i < xs.length; i++) {
      const d = (u.valToPos(xs[i], "x") - left) ** 2 + (u.valToPos(ys[i], "y") - top) ** 2;
      if (d < least) [best, least] = [i, d];
    }
    return best;
  }

  function path(u, s) {
    const line = new Path2D();
    const [xs, ys] = u.data[s];
    for (let i = 0; i < xs.length; i++) {
      if (xs[i] == null || ys[i] == null) continue;
      line.lineTo(u.valToPos(xs[i], "x", true), u.valToPos(ys[i], "y", true));
    }
    return { stroke: line, fill: null, clip: null, flags: 1 };
  }

  function paths(plot, box) {
    const height = Math.min(420, Math.max(260, 0.75 * box.clientWidth));
    const [x, y] = equalRanges(plot, box.clientWidth - 74, height - 60);
    const value = (u, v, s, i) => (i == null ? "–" : `(${u.data[s].map((a) => shown(a[i])).join(", ")})`);
    const options = {
      ...frame(plot, box),
      mode: 2,
      height,
      scales: { x: { time: false, range: (u, a, b) => (zoomed(u) ? [a, b] : x) }, y: { range: (u, a, b) => (zoomed(u) ? [a, b] : y) } },
      series: [
        {},
        ...plot.names.map((label, i) => ({
          label, ...look(i), paths: path, points: { show: false }, value, facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }],
        })),
      ],
    };
    options.cursor.dataIdx = (u, s) => (s == 0 ? null : nearest(u, plot.arrays[s - 1]));
    return new uPlot(options, [null, ...plot.arrays.map((pair) => pair.map(array))], box);
  }

  // A drag has just selected a range, which must then be taken as it is.
  const zoomed = (u) => u.select != null && u.select.width > 0;

  function draw() {
    live.forEach((u) => u.destroy());
    live = [...document.querySelectorAll("[data-plot]")].map((box) => {
      const plot = data.plots[box.dataset.plot];
      return plot.kind === "over" ? functions(plot, box) : paths(plot, box);
    });
  }

  draw();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  printing.addEventListener("change", draw);
  let timer;
  addEventListener("resize", () => {
    clearTimeout(timer);
    timer = setTimeout(() => printing.matches || draw(), 150);
  });
})();
