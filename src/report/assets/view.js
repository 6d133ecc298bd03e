"use strict";
// Views in space: what moves, the time that passes, and the controls below. Draws on a Stage.
(async () => {
  const { data, floats, style, shown } = globalThis.report;
  const boxes = [...document.querySelectorAll("[data-scene]")];
  const say = (text) => boxes.forEach((box) => box.classList.add("empty") || (box.textContent = text));

  try {
    const bytes = Uint8Array.from(atob(document.getElementById("three").textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    const script = document.createElement("script");
    script.textContent = await new Response(stream).text();
    document.head.append(script);
  } catch (error) {
    return say(`This browser cannot show the structure in space (${error.message}); one of the last few years can.`);
  }

  const element = (tag, attributes = {}, ...children) => {
    const out = Object.assign(document.createElement(tag), attributes);
    out.append(...children);
    return out;
  };
  const mix = (a, b, share) => a + (b - a) * share;

  // q v q* for a quaternion (w, x, y, z).
  function turned([w, x, y, z], [a, b, c]) {
    const [u, v, t] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
    return [a + w * u + y * t - z * v, b + w * v + z * u - x * t, c + w * t + x * v - y * u];
  }

  // Frame and share of the way to the next one at time t.
  function place(times, t) {
    let [low, high] = [0, times.length - 1];
    if (high <= 0 || t <= times[0]) return [0, 0];
    if (t >= times[high]) return [high - 1, 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= t) low = middle;
      else high = middle;
    }
    return [low, (t - times[low]) / (times[high] - times[low])];
  }

  // A body at an instant: its amplitudes, where A is, and vectors of its tracks.
  class Body {
    constructor(given, rest) {
      this.name = given.name;
      this.rest = rest;
      for (const key of ["t", "origin", "attitude", "shapes", "amplitudes"]) this[key] = floats(given[key]);
      this.points = given.points.map((p) => ({ ...p, displacement: floats(p.displacement) }));
      this.arrows = given.arrows.map((a) => ({ ...a, vector: floats(a.vector) }));
      this.k = this.amplitudes.length / Math.max(1, this.t.length);
      this.nodes = new Float32Array(rest.length);
    }

    row(values, width, [i, share]) {
      const j = Math.min(i + 1, this.t.length - 1);
      return Array.from({ length: width }, (_, c) => mix(values[width * i + c], values[width * j + c], share));
    }

    // From A to what is looked at: "G", "follow" (axes of G that go with A) or "A".
    frame(at, seen) {
      const zeta = this.row(this.attitude, 4, at);
      const norm = Math.hypot(...zeta) || 1;
      const q = seen === "A" ? [1, 0, 0, 0] : zeta.map((z) => z / norm);
      const r = seen === "G" ? this.row(this.origin, 3, at) : [0, 0, 0];
      return { r, q, map: (x) => turned(q, x).map((v, k) => v + r[k]), back: (v) => (seen === "A" ? turned([zeta[0], -zeta[1], -zeta[2], -zeta[3]].map((z) => z / norm), v) : v) };
    }

    // Positions of all nodes.
    place(at, seen, scale) {
      const a = this.row(this.amplitudes, this.k, at);
      const { q, r } = this.frame(at, seen);
      deform(this.nodes, this.rest, this.shapes, a.map((v) => scale * v));
      // Columns of the rotation matrix, so that every node costs nine products.
      const [ex, ey, ez] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map((e) => turned(q, e));
      for (let n = 0; n < this.nodes.length; n += 3) {
        const [x, y, z] = [this.nodes[n], this.nodes[n + 1], this.nodes[n + 2]];
        for (let k = 0; k < 3; k++) this.nodes[n + k] = r[k] + ex[k] * x + ey[k] * y + ez[k] * z;
      }
      return this.nodes;
    }

    point(index, at, seen, scale) {
      const { rest, displacement } = this.points[index];
      const d = this.row(displacement, 3, at);
      return this.frame(at, seen).map(rest.map((x, k) => x + scale * d[k]));
    }
  }

  // nodes = rest + shapes amplitudes
  function deform(nodes, rest, shapes, amplitudes) {
    const k = amplitudes.length;
    const stored = shapes.length / rest.length;
    for (let i = 0; i < rest.length; i++) {
      let x = rest[i];
      if (stored === k) for (let j = 0; j < k; j++) x += shapes[i * k + j] * amplitudes[j];
      nodes[i] = x;
    }
  }

  function boundary() {
    const [least, most] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    const see = (nodes) => {
      for (let i = 0; i < nodes.length; i++) {
        least[i % 3] = Math.min(least[i % 3], nodes[i]);
        most[i % 3] = Math.max(most[i % 3], nodes[i]);
      }
    };
    return { least, most, see };
  }

  const SPEEDS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
  const SCALES = [1, 2, 5, 10, 20, 50, 100, 1000];

  class View {
    constructor(box, given) {
      this.box = box;
      this.rest = floats(given.positions);
      this.segments = floats(given.segments);
      this.bodies = given.bodies.map((body) => new Body(body, this.rest));
      this.modes = { names: given.modes.names, shapes: floats(given.modes.shapes), rigid: floats(given.modes.rigid) };
      const whole = boundary();
      whole.see(this.rest);
      this.size = Math.hypot(...whole.most.map((x, k) => x - whole.least[k])) || 1;
      this.end = Math.max(0, ...this.bodies.map((body) => body.t[body.t.length - 1] ?? 0));
      const slow = SPEEDS.findLast((s) => s <= this.end / 6) ?? SPEEDS[0];
      this.state = { t: 0, phase: 0, playing: false, seen: this.seen(), scale: 1, speed: Math.min(1, slow), mode: this.bodies.length ? -1 : 0, trails: true, loads: true, undeformed: false, hidden: new Set() };
      this.stage = new Stage(box, this.size, style);
      this.build();
      this.controls();
      this.aim();
      addEventListener("keydown", (event) => event.key === " " && event.target === this.stage.renderer.domElement && (event.preventDefault(), this.play()));
      this.stage.renderer.domElement.tabIndex = 0;
      new ResizeObserver(() => { this.stage.resize(); this.draw(); }).observe(box);
    }

    // A body that goes far from where it starts is followed, or it would be a dot.
    seen() {
      const far = this.bodies.some((body) => {
        for (let i = 0; i < body.t.length; i++) {
          if (Math.hypot(...[0, 1, 2].map((k) => body.origin[3 * i + k] - body.origin[k])) > 5 * this.size) return true;
        }
        return false;
      });
      return far ? "follow" : "G";
    }

    colour(i) {
      return style(`--c${i % 10}`);
    }

    build() {
      (this.objects ?? []).forEach((object) => this.stage.drop(object));
      this.objects = [];
      const keep = (object) => (this.objects.push(object), object);
      const tubes = (colour, thickness, opacity) => {
        const made = this.stage.tubes(this.segments, colour, thickness, opacity);
        keep(made.mesh);
        return made;
      };
      this.ghost = tubes(style("--muted"), 0.002, 0.5);
      this.shape = this.modes.names.length ? tubes(this.colour(0), 0.0045) : null;
      const [force, moment] = [style("--c1"), style("--c3")];
      this.drawn = this.bodies.map((body, i) => ({
        // The first is what the others are compared with: it shows around them where they agree.
        tubes: i || this.bodies.length < 2 ? tubes(this.colour(i), 0.004) : tubes(this.colour(i), 0.008, 0.45),
        balls: body.points.slice(0, 40).map(() => keep(this.stage.ball(this.colour(i), 0.009))),
        trails: body.points.slice(0, 8).map(() => keep(this.stage.track(this.colour(i)))),
        arrows: body.arrows.map((a) => {
          const arrow = this.stage.arrow(a.moment ? moment : force, a.moment);
          keep(arrow.group);
          return arrow;
        }),
      }));
      const longest = (isMoment) => {
        const lengths = this.bodies.flatMap((b) => b.arrows.filter((a) => a.moment === isMoment).map((a) => {
          let most = 0;
          for (let i = 0; i < a.vector.length; i += 3) most = Math.max(most, Math.hypot(a.vector[i], a.vector[i + 1], a.vector[i + 2]));
          return most;
        }));
        return Math.max(0, ...lengths);
      };
      this.largest = [longest(false), longest(true)];
      this.trails();
    }

    // Tracks of the points as they are seen now.
    trails() {
      this.bodies.forEach((body, b) => this.drawn[b].trails.forEach((line, p) => {
        const path = new Float32Array(3 * body.t.length);
        for (let i = 0; i < body.t.length; i++) path.set(body.point(p, [i, 0], this.state.seen, this.state.scale), 3 * i);
        line.geometry.setAttribute("position", new THREE.BufferAttribute(path, 3));
      }));
    }

    // The camera where all of the motion is in sight.
    aim() {
      const { seen, scale, mode } = this.state;
      const around = boundary();
      if (mode >= 0 || !this.bodies.length) {
        [-1, 1].forEach((sign) => around.see(this.modeShape(sign)));
      } else {
        for (const body of this.bodies) {
          const step = Math.max(1, Math.floor(body.t.length / 60));
          for (let i = 0; i < body.t.length; i += step) around.see(body.place([i, 0], seen, scale));
        }
      }
      const cell = this.stage.ground(around);
      this.stage.grid.visible = seen === "G" && mode < 0;
      this.note.textContent = this.stage.grid.visible ? `Cells of the ground ${shown(cell)} m.` : "";
      this.stage.look(around);
      this.draw();
    }

    modeShape(amplitude) {
      const m = this.modes.names.length;
      const nodes = new Float32Array(this.rest);
      const j = this.state.mode;
      if (!(j >= 0 && j < m)) return nodes;
      const moved = new Float32Array(this.rest.length);
      const [v, w] = [0, 3].map((first) => [0, 1, 2].map((k) => this.modes.rigid[(first + k) * m + j]));
      let most = 0;
      for (let n = 0; n < this.rest.length; n += 3) {
        const [x, y, z] = [this.rest[n], this.rest[n + 1], this.rest[n + 2]];
        const swept = [w[1] * z - w[2] * y, w[2] * x - w[0] * z, w[0] * y - w[1] * x];
        for (let k = 0; k < 3; k++) {
          const relative = this.modes.shapes[(n + k) * m + j];
          moved[n + k] = relative + (this.state.seen === "A" ? 0 : v[k] + swept[k]);
        }
        most = Math.max(most, Math.hypot(moved[n], moved[n + 1], moved[n + 2]));
      }
      const scale = most ? (0.12 * this.size * amplitude) / most : 0;
      for (let i = 0; i < nodes.length; i++) nodes[i] += scale * moved[i];
      return nodes;
    }

    draw() {
      const { t, phase, seen, scale, mode, trails, loads, undeformed, hidden } = this.state;
      const ofMode = mode >= 0;
      if (this.shape) {
        this.shape.mesh.visible = ofMode;
        if (ofMode) this.shape.set(this.modeShape(Math.cos(2 * Math.PI * phase)));
      }
      this.stage.axes.G.visible = !ofMode && seen === "G";
      this.ghost.mesh.visible = undeformed || ofMode;
      this.bodies.forEach((body, b) => {
        const { tubes, balls, trails: lines, arrows } = this.drawn[b];
        const visible = !ofMode && !hidden.has(b);
        const at = place(body.t, t);
        tubes.mesh.visible = visible;
        if (visible) tubes.set(body.place(at, seen, scale));
        balls.forEach((ball, p) => {
          ball.visible = visible;
          if (visible) ball.position.set(...body.point(p, at, seen, scale));
        });
        lines.forEach((line) => {
          line.visible = visible && trails;
          line.geometry.setDrawRange(0, at[0] + 1 + Math.round(at[1]));
        });
        arrows.forEach((arrow, i) => {
          const { moment, point, vector } = body.arrows[i];
          const value = body.frame(at, seen).back(body.row(vector, 3, at));
          const largest = this.largest[Number(moment)];
          const length = largest ? (0.28 * this.size * Math.hypot(...value)) / largest : 0;
          if (visible && loads && length) arrow.set(body.point(point, at, seen, scale), value, length);
          else arrow.group.visible = false;
        });
      });
      const first = this.bodies.findIndex((_, b) => !hidden.has(b));
      const lead = !ofMode && first >= 0 ? this.bodies[first].frame(place(this.bodies[first].t, t), seen) : null;
      const { A } = this.stage.axes;
      A.position.set(...(lead ? lead.r : [0, 0, 0]));
      A.quaternion.set(...(lead ? [lead.q[1], lead.q[2], lead.q[3], lead.q[0]] : [0, 0, 0, 1]));
      if (this.ghost.mesh.visible) {
        const nodes = new Float32Array(this.rest);
        if (lead) for (let n = 0; n < nodes.length; n += 3) nodes.set(lead.map([nodes[n], nodes[n + 1], nodes[n + 2]]), n);
        this.ghost.set(nodes);
      }
      this.clock.textContent = ofMode ? "" : `t = ${t.toFixed(this.end < 10 ? 3 : 2)} s`;
      this.slider.value = String(ofMode ? phase : t / (this.end || 1));
      this.stage.render();
    }

    play(on = !this.state.playing) {
      this.state.playing = on;
      this.button.textContent = on ? "Pause" : "Play";
      let last = null;
      const tick = (now) => {
        if (!this.state.playing) return;
        const passed = last == null ? 0 : Math.min(0.1, (now - last) / 1000);
        last = now;
        if (this.state.mode >= 0) this.state.phase = (this.state.phase + 0.5 * passed) % 1;
        else this.state.t = this.state.t >= this.end ? 0 : Math.min(this.end, this.state.t + passed * this.state.speed);
        this.draw();
        requestAnimationFrame(tick);
      };
      if (on) requestAnimationFrame(tick);
    }

    controls() {
      const { state } = this;
      const select = (label, options, value, change) => {
        const list = element("select", {}, ...options.map(([v, text]) => element("option", { value: v, textContent: text })));
        list.value = value;
        list.addEventListener("change", () => change(list.value));
        return element("label", {}, `${label} `, list);
      };
      const tick = (label, on, change) => {
        const box = element("input", { type: "checkbox", checked: on });
        box.addEventListener("change", () => { change(box.checked); this.draw(); });
        return element("label", {}, box, ` ${label}`);
      };
      this.button = element("button", { type: "button", textContent: "Play" });
      this.button.addEventListener("click", () => this.play());
      this.slider = element("input", { type: "range", min: 0, max: 1, step: "any", value: 0, ariaLabel: "time" });
      this.slider.addEventListener("input", () => {
        if (state.mode >= 0) state.phase = Number(this.slider.value);
        else state.t = Number(this.slider.value) * this.end;
        this.draw();
      });
      this.clock = element("output");
      const reset = element("button", { type: "button", textContent: "Reset view" });
      reset.addEventListener("click", () => this.aim());
      const changed = () => { this.trails(); this.aim(); };
      const what = [...(this.bodies.length ? [["-1", "motion"]] : []), ...this.modes.names.map((name, j) => [String(j), name])];
      const seen = [["G", "frame G"], ["follow", "beside A, axes of G"], ["A", "frame A"]];
      const parts = [
        element("div", { className: "time" }, this.button, this.slider, this.clock),
        what.length > 1 && select("show", what, String(state.mode), (v) => { state.mode = Number(v); this.aim(); }),
        select("seen from", this.bodies.length ? seen : seen.filter(([v]) => v !== "follow"), state.seen, (v) => { state.seen = v; changed(); }),
        this.bodies.length && select("deformation", SCALES.map((s) => [String(s), `× ${s}`]), "1", (v) => { state.scale = Number(v); changed(); }),
        this.bodies.length && select("speed", SPEEDS.map((s) => [String(s), `× ${s}`]), String(state.speed), (v) => (state.speed = Number(v))),
        this.bodies.length && tick("trails", state.trails, (on) => (state.trails = on)),
        this.bodies.some((b) => b.arrows.length) && tick("loads", state.loads, (on) => (state.loads = on)),
        this.bodies.length && tick("undeformed", state.undeformed, (on) => (state.undeformed = on)),
        reset,
      ];
      const legend = this.bodies.length > 1 ? this.bodies.map((body, b) => {
        const label = tick(body.name, true, (on) => (on ? state.hidden.delete(b) : state.hidden.add(b)));
        label.style.setProperty("--key", `var(--c${b % 10})`);
        label.className = "key";
        return label;
      }) : [];
      this.note = element("span", { className: "note" });
      this.box.append(element("div", { className: "controls" }, ...parts.filter(Boolean), ...legend, this.note));
    }
  }

  let views = [];
  try {
    views = boxes.map((box) => new View(box, data.scenes[box.dataset.scene]));
  } catch (error) {
    return say(`The structure in space cannot be shown: ${error.message}`);
  }
  const again = () => views.forEach((view) => { view.build(); view.aim(); });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", again);
  matchMedia("print").addEventListener("change", again);
  globalThis.report.views = views;
})();
