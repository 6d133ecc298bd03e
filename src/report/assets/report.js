"use strict";
(() => {
  const data = JSON.parse(document.getElementById("data").textContent);
  const decoded = new Map();
  const printing = matchMedia("print");
  let live = [];

  // Little-endian f32 in base64.
  function floats(index) {
    const bytes = Uint8Array.from(atob(data.arrays[index]), (c) => c.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    return Float32Array.from({ length: bytes.length / 4 }, (_, i) => view.getFloat32(4 * i, true));
  }

  // For the plotter, to which gaps are null and not NaN.
  function array(index) {
    if (!decoded.has(index)) decoded.set(index, Array.from(floats(index), (v) => (Number.isNaN(v) ? null : v)));
    return decoded.get(index);
  }

  const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const shown = (v) => (v == null ? "–" : String(Number(v.toPrecision(5))));
  // Ten colours, then the same ten dashed.
  const look = (i) => ({ stroke: style(`--c${i % 10}`), width: 1.5, dash: i < 10 ? undefined : [6, 3] });

  // Stages of one thing go from light to dark.
  function curve(plot, i) {
    if (!plot.stages) return look(i);
    const share = Math.round(25 + (75 * i) / Math.max(1, plot.names.length - 1));
    return { stroke: `color-mix(in srgb, ${style("--text")} ${share}%, ${style("--page")})`, width: 1 };
  }

  // On a logarithmic axis only the powers of ten, and the values between where there is room, are written out.
  const sparse = (u, splits) => {
    const decades = splits.filter((v) => v > 0 && Number.isInteger(Math.log10(v))).length;
    return splits.map((v) => (v > 0 && (decades < 2 || Number.isInteger(Number(Math.log10(v).toFixed(9)))) ? v : null));
  };
  const gaps = (values) => values.map((v) => (v > 0 ? v : null));

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

  // Clouds of points do not end at the axes, and may have no width, to which the plotter would give a hundred.
  function airy(u, least, most) {
    const [first, last] = [u.data[0][0], u.data[0].at(-1)];
    const air = first === last ? 0.5 * Math.max(Math.abs(first), 1) : 0.05 * (most - least);
    return first === last ? [first - air, first + air] : [least - air, most + air];
  }

  function functions(plot, box) {
    const scale = (log) => (log ? { distr: 3, log: 10 } : {});
    const options = {
      ...frame(plot, box),
      height: 250,
      scales: { x: { time: false, ...scale(plot.logX), ...(plot.scattered && { range: airy }) }, y: scale(plot.logY) },
      legend: { show: !plot.stages },
      series: [
        { label: plot.x, value: (u, v) => shown(v) },
        ...plot.names.map((label, i) => ({
          label, ...curve(plot, i), ...(plot.scattered && { paths: () => null }),
          points: { show: plot.markers, size: 6 }, value: (u, v) => shown(v),
        })),
      ],
    };
    [plot.logX, plot.logY].forEach((log, k) => log && (options.axes[k].filter = sparse));
    // The cursor shows the same abscissa in all plots that share it.
    options.cursor.sync = { key: `x${plot.arrays[0]}` };
    return new uPlot(options, plot.arrays.map((a, k) => (k && plot.logY ? gaps(array(a)) : array(a))), box);
  }

  // The smallest ranges about two extents for which a unit is equally long on both axes of w by h pixels.
  function equalRanges([x, y], w, h) {
    if (!(x[0] <= x[1])) return { x: [-1, 1], y: [-1, 1] };
    const span = Math.max((x[1] - x[0]) / w, (y[1] - y[0]) / h) || 1 / h;
    const about = ([a, b], size) => [(a + b - span * size) / 2, (a + b + span * size) / 2];
    return { x: about(x, w), y: about(y, h) };
  }

  // Smallest and largest abscissa and ordinate of all paths, with some air around.
  function extents(plot) {
    return [0, 1].map((k) => {
      const all = plot.arrays.flatMap((pair) => array(pair[k])).filter((v) => v != null);
      const [a, b] = all.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
      return [a - 0.05 * (b - a), b + 0.05 * (b - a)];
    });
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

  const ringless = new WeakSet();

  function path(u, s) {
    const line = new Path2D();
    const [xs, ys] = u.data[s];
    for (let i = 0; i < xs.length; i++) {
      if (xs[i] == null || ys[i] == null) continue;
      line.lineTo(u.valToPos(xs[i], "x", true), u.valToPos(ys[i], "y", true));
    }
    // A ring marks the start.
    const start = ringless.has(u) ? -1 : xs.findIndex((x, i) => x != null && ys[i] != null);
    if (start >= 0) {
      const [x, y, r] = [u.valToPos(xs[start], "x", true), u.valToPos(ys[start], "y", true), 4 * devicePixelRatio];
      line.moveTo(x + r, y);
      line.arc(x, y, r, 0, 2 * Math.PI);
    }
    return { stroke: line, fill: null, clip: null, flags: 1 };
  }

  function paths(plot, box) {
    const height = Math.min(440, Math.max(260, 0.8 * box.clientWidth));
    const whole = equalRanges(extents(plot), box.clientWidth - 74, height - 60);
    let view = whole;
    function show(u, next) {
      view = next;
      u.batch(() => ["x", "y"].forEach((k) => u.setScale(k, { min: view[k][0], max: view[k][1] })));
    }
    function zoom(u) {
      const { left, top, width, height } = u.select;
      if (width < 3 && height < 3) return;
      const x = [left, left + width].map((p) => u.posToVal(p, "x"));
      const y = [top + height, top].map((p) => u.posToVal(p, "y"));
      u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
      show(u, equalRanges([x, y], u.over.clientWidth, u.over.clientHeight));
    }
    const value = (u, v, s, i) => (i == null ? "–" : `(${u.data[s].map((a) => shown(a[i])).join(", ")})`);
    const options = {
      ...frame(plot, box),
      mode: 2,
      height,
      legend: { show: !plot.stages },
      scales: { x: { time: false, range: () => view.x }, y: { range: () => view.y } },
      series: [
        {},
        ...plot.names.map((label, i) => ({
          label, ...curve(plot, i), paths: path, points: { show: false }, value, facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }],
        })),
      ],
      hooks: { setSelect: [zoom], init: [(u) => plot.stages && ringless.add(u)], ready: [(u) => u.over.addEventListener("dblclick", () => show(u, whole))] },
    };
    options.cursor.drag = { x: true, y: true, setScale: false };
    options.cursor.dataIdx = (u, s) => (s == 0 ? null : nearest(u, plot.arrays[s - 1]));
    return new uPlot(options, [null, ...plot.arrays.map((pair) => pair.map(array))], box);
  }

  function draw() {
    live.forEach((u) => u.destroy());
    live = [...document.querySelectorAll("[data-plot]")].map((box) => {
      const plot = data.plots[box.dataset.plot];
      return plot.kind === "over" ? functions(plot, box) : paths(plot, box);
    });
  }

  // What views in space share with the plots.
  globalThis.report = { data, floats, style, shown };

  draw();
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  printing.addEventListener("change", draw);
  let timer;
  addEventListener("resize", () => {
    clearTimeout(timer);
    timer = setTimeout(() => printing.matches || draw(), 150);
  });
})();
