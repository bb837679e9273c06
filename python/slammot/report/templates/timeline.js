// One slider over the image, the map and the series. As in page.js, what was drawn or the first error is left on <html> for
// whoever tests the page. Labels are 0 static, 1 unknown, 2 moving, 3 none; each has its colour, shape and line.
"use strict";

const COLOURS = ["#0072B2", "#CC79A7", "#D55E00", "#5f6772"];
const DASHES = [[], [2, 3], [9, 3], []];
const NAMES = ["static", "unknown", "moving", "no landmark"];
const INK = "#1b1f24", GREY = "#969696", RULE = "#d9dde2";
const TRAIL = 8, STRIP = 96, LEFT = 58;

// A canvas as wide as its place, `height` high, cleared.
function cleared(canvas, height) {
  const width = canvas.clientWidth, ratio = window.devicePixelRatio || 1;
  canvas.style.height = `${height}px`;
  canvas.width = Math.round(width * ratio);
  canvas.height = Math.round(height * ratio);
  const c = canvas.getContext("2d");
  c.scale(ratio, ratio);
  c.font = "12px system-ui, 'DejaVu Sans', sans-serif";
  return [c, width, height];
}

function line(c, points, colour, width = 1, dash = []) {
  c.beginPath();
  let pen = false;
  for (const p of points) {
    if (!p) pen = false;
    else pen = (pen ? c.lineTo(...p) : c.moveTo(...p), true);
  }
  Object.assign(c, {strokeStyle: colour, lineWidth: width});
  c.setLineDash(dash);
  c.stroke();
  c.setLineDash([]);
}

// Disc, open square, diamond, cross: with a white rim, so that they are seen on any image.
function mark(c, label, x, y, size = 4.5) {
  c.beginPath();
  if (label === 0) c.arc(x, y, size, 0, 2 * Math.PI);
  if (label === 1) c.rect(x - size, y - size, 2 * size, 2 * size);
  if (label === 2) [[0, -1.5], [1.5, 0], [0, 1.5], [-1.5, 0]].forEach(([a, b]) => c.lineTo(x + a * size, y + b * size));
  if (label === 3) [[-1, -1, 1, 1], [-1, 1, 1, -1]].forEach(([a, b, d, e]) => { c.moveTo(x + a * size, y + b * size); c.lineTo(x + d * size, y + e * size); });
  if (label === 2) c.closePath();
  Object.assign(c, {strokeStyle: "#fff", lineWidth: 4, fillStyle: COLOURS[label]});
  c.stroke();
  if (label === 0 || label === 2) c.fill();
  Object.assign(c, {strokeStyle: COLOURS[label], lineWidth: 2});
  if (label === 1 || label === 3) c.stroke();
}

function camera(c, x, y, dx, dy) {
  const length = Math.hypot(dx, dy) || 1, a = 16 * dx / length, b = 16 * dy / length;
  line(c, [[x + a - 0.5 * b, y + b + 0.5 * a], [x, y], [x + a + 0.5 * b, y + b - 0.5 * a]], "#fff", 5);
  line(c, [[x + a - 0.5 * b, y + b + 0.5 * a], [x, y], [x + a + 0.5 * b, y + b - 0.5 * a]], INK, 2.5);
}

function place_text(c, text, x, y, align = "left", colour = INK) {
  Object.assign(c, {fillStyle: colour, textAlign: align, textBaseline: "middle"});
  c.fillText(text, x, y);
}

// A round step, of which about `count` lie in `range`.
function step_of(range, count) {
  const power = 10 ** Math.floor(Math.log10(range / count));
  return [1, 2, 5, 10].map((f) => f * power).find((s) => range / s <= count) || 10 * power;
}

function short(value) { return value === null ? "–" : String(Number(value.toPrecision(3))); }

class Page {
  constructor(data) {
    this.data = data;
    this.at = 0;
    this.cameras = [...Array(1 + data.frames[0].others.length).keys()];
    this.pictures = [data.pictures, ...data.other_pictures];
    this.images = this.cameras.map(() => data.frames.map(() => null));
    this.slider = document.getElementById("frame");
    this.slider.max = data.frames.length - 1;
    this.strips = data.series.map((series) => this.strip_of(series));
    this.last = Math.max(...data.path.map((p) => p[0]));
  }

  strip_of(series) {
    const place = document.getElementById("series"), head = document.createElement("h2");
    head.textContent = series.name + (series.unit ? ` [${series.unit}]` : "");
    place.append(head);
    const canvas = document.createElement(series.lines.length ? "canvas" : "p");
    if (!series.lines.length) {
      canvas.textContent = series.why;
      canvas.className = "none";
      place.append(canvas);
      return null;
    }
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", series.name);
    place.append(canvas);
    const seek = (event) => {
      const part = (event.offsetX - LEFT) / (canvas.clientWidth - LEFT - 1);
      this.show(Math.round(part * (this.data.count - 1) / this.data.every));
    };
    canvas.addEventListener("pointerdown", seek);
    canvas.addEventListener("pointermove", (event) => event.buttons && seek(event));
    return canvas;
  }

  get frame() { return this.data.frames[this.at]; }

  // Those of the frame: final ones where it measures them, and what rests.
  get landmarks() {
    if (this.frame.landmarks) return this.frame.landmarks;
    const measured = new Set(this.frame.tracks.map((t) => t[0]));
    return this.data.landmarks.map(([label, track, ...at]) => [label, measured.has(track), ...at]).filter(([label, seen]) => seen || label === 0);
  }

  // A camera's picture of the frame, once it is decoded.
  image(camera) {
    const pictures = this.pictures[camera], images = this.images[camera], at = this.at;
    if (!pictures || !pictures[at]) return null;
    if (!images[at]) {
      const image = images[at] = new Image();
      image.onload = () => at === this.at && this.draw();
      image.src = pictures[at];
    }
    return images[at].complete ? images[at] : null;
  }

  draw_image(camera) {
    const canvas = document.getElementById(`image-${camera}`), {width, height, frames} = this.data;
    const [c, across, down] = cleared(canvas, canvas.clientWidth * height / width), scale = across / width;
    c.fillStyle = "#f5f6f8";
    c.fillRect(0, 0, across, down);
    const image = this.image(camera), tracks_of = (frame) => camera ? frame.others[camera - 1] : frame.tracks, tracks = tracks_of(this.frame);
    if (image) c.drawImage(image, 0, 0, across, down);
    const on_canvas = ([, u, v]) => [(u + 0.5) * scale, (v + 0.5) * scale];
    const before = frames.slice(Math.max(0, this.at - TRAIL), this.at).map((f) => new Map(tracks_of(f).map((t) => [t[0], t])));
    for (const track of tracks) {
      const trail = [...before.map((f) => f.get(track[0])).map((t) => t ? on_canvas(t) : null), on_canvas(track)];
      line(c, trail, "#fff", 3.5);
      line(c, trail, COLOURS[track[3]], track[3] === 2 ? 2.5 : 1.5, track[3] === 1 ? DASHES[1] : []);
    }
    // What moves lies on top.
    for (const label of [3, 0, 1, 2]) tracks.filter((t) => t[3] === label).forEach((t) => mark(c, label, ...on_canvas(t)));
  }

  draw_map() {
    const canvas = document.getElementById("map"), [left, right, near, far] = this.data.shown;
    const [c, width, height] = cleared(canvas, Math.min(Math.max(canvas.clientWidth * 0.8, 260), 560));
    const room = [width - LEFT, height - 24], scale = Math.min(room[0] / (right - left), room[1] / (far - near));
    const x = (m) => LEFT + room[0] / 2 + scale * (m - (left + right) / 2), y = (m) => room[1] / 2 - scale * (m - (near + far) / 2);
    this.draw_grid(c, room, scale, x, y);
    c.save();
    c.beginPath();
    c.rect(LEFT, 0, ...room);
    c.clip();
    const flat = (points, now) => points.filter((p) => !now || p[0] <= this.frame.frame).map((p) => [x(p[1]), y(p[2])]);
    line(c, flat(this.data.truth, false), GREY, 1.5, [6, 4]);
    line(c, flat(this.data.path, false), RULE, 2);
    line(c, flat(this.data.path, true), INK, 2);
    this.draw_landmarks(c, x, y);
    const place = this.data.path.filter((p) => p[0] <= this.frame.frame).length - 1;
    if (place >= 0) {
      const [dx, dy] = this.data.heading[place];
      camera(c, x(this.data.path[place][1]), y(this.data.path[place][2]), dx, -dy);
    }
    c.restore();
  }

  draw_landmarks(c, x, y) {
    const landmarks = this.landmarks;
    for (const [label, measured, px, py] of landmarks) {
      if (!measured) Object.assign(c, {fillStyle: GREY}).fillRect(x(px) - 1.5, y(py) - 1.5, 3, 3);
    }
    for (const [label, measured, px, py, dx, dy] of landmarks) {
      if (!measured) continue;
      if (dx !== undefined && dx !== null) line(c, [[x(px), y(py)], [x(px + dx), y(py + dy)]], COLOURS[label], 2);
      mark(c, label, x(px), y(py), 3.5);
    }
  }

  draw_grid(c, [width, height], scale, x, y) {
    const step = step_of(Math.min(width, height) / scale, 5), middle = this.data.shown;
    for (const [axis, from, to] of [["x", 0, width], ["y", 0, height]]) {
      const centre = axis === "x" ? (middle[0] + middle[1]) / 2 : (middle[2] + middle[3]) / 2, half = (axis === "x" ? width : height) / 2 / scale;
      for (let k = Math.ceil((centre - half) / step); k * step <= centre + half; ++k) {
        const text = String(Number((k * step).toPrecision(6)));
        if (axis === "x") {
          line(c, [[x(k * step), 0], [x(k * step), height]], RULE);
          place_text(c, text, x(k * step), height + 10, "center");
        } else {
          line(c, [[LEFT, y(k * step)], [LEFT + width, y(k * step)]], RULE);
          place_text(c, text, LEFT - 6, y(k * step), "right");
        }
      }
    }
  }

  draw_strip(canvas, series) {
    const [c, width, height] = cleared(canvas, STRIP), across = width - LEFT - 1, count = this.data.count;
    const known = series.lines.flat().filter((v) => v !== null && (!series.log || v > 0));
    if (!known.length) return;
    const of = series.log ? Math.log10 : (v) => v, all = known.map(of).concat((series.band || []).map(of));
    const low = series.log ? Math.min(...all) : 0, high = Math.max(...all, low + 1e-9), room = height - 14;
    const x = (k) => LEFT + across * k / Math.max(count - 1, 1), y = (v) => 7 + room * (1 - (of(v) - low) / (high - low));
    if (series.band) Object.assign(c, {fillStyle: "#e7e9ec"}).fillRect(LEFT, y(series.band[1]), across, y(series.band[0]) - y(series.band[1]));
    if (series.expected) line(c, [[LEFT, y(series.expected)], [LEFT + across, y(series.expected)]], GREY, 1, [4, 3]);
    const ends = series.log ? [10 ** low, 10 ** high] : [0, high], clear = ends.every((v) => Math.abs(y(v) - y(series.expected)) > 13);
    for (const value of clear ? [...ends, series.expected] : ends) place_text(c, short(value), LEFT - 6, y(value), "right");
    series.lines.forEach((values, label) => {
      line(c, values.map((v, k) => v === null || (series.log && v <= 0) ? null : [x(k), y(v)]), series.labels ? COLOURS[label] : INK, series.labels ? 2 : 1.3, series.labels ? DASHES[label] : []);
    });
    const now = x(this.frame.frame), there = series.lines.map((values) => short(values[this.frame.frame]));
    line(c, [[now, 0], [now, height]], "#D55E00", 2);
    const text = series.labels ? there.map((value, label) => `${value} ${NAMES[label]}`).join(", ") : there[0], end = now + 8 + c.measureText(text).width > width;
    Object.assign(c, {fillStyle: "rgba(255, 255, 255, 0.85)"}).fillRect(end ? now - 12 - c.measureText(text).width : now + 4, 2, c.measureText(text).width + 8, 16);
    place_text(c, text, end ? now - 8 : now + 8, 10, end ? "right" : "left");
  }

  draw() {
    this.cameras.forEach((camera) => this.draw_image(camera));
    this.draw_map();
    this.strips.forEach((canvas, i) => canvas && this.draw_strip(canvas, this.data.series[i]));
    const counts = [0, 1, 2, 3].map((label) => this.frame.tracks.filter((t) => t[3] === label).length);
    document.getElementById("state").textContent = `frame ${this.frame.frame} of ${this.data.count - 1}, ${this.frame.time.toFixed(2)} s: measured ` +
      counts.map((n, label) => `${n} ${NAMES[label]}`).join(", ") + this.frame.others.map((tracks, k) => `; by camera ${k + 1}: ${tracks.length}`).join("") + (this.frame.frame > this.last ? "; the run has ended before" : "");
    Object.assign(document.documentElement.dataset, {drawn: this.frame.frame, marks: counts.join(), image: this.cameras.map((camera) => Boolean(this.image(camera))).join()});
  }

  show(at) {
    this.at = Math.min(Math.max(at, 0), this.data.frames.length - 1);
    this.slider.value = this.at;
    this.draw();
    history.replaceState(null, "", `#frame=${this.frame.frame}`);
  }

  // As the address says; the nearest that is shown.
  show_address() {
    const asked = Number((/^#frame=(\d+)$/.exec(location.hash) || [0, 0])[1]);
    this.show(Math.round(asked / this.data.every));
  }

  play() {
    const button = document.getElementById("play"), frames = this.data.frames;
    if (this.timer) this.timer = clearInterval(this.timer);
    else {
      if (this.at === frames.length - 1) this.show(0);
      const pause = 1000 * (frames.at(-1).time - frames[0].time) / Math.max(frames.length - 1, 1);
      this.timer = setInterval(() => this.at < frames.length - 1 ? this.show(this.at + 1) : this.play(), Math.min(Math.max(pause, 40), 1000));
    }
    button.textContent = this.timer ? "❚❚ pause" : "▶ play";
  }
}

function start() {
  for (const canvas of document.querySelectorAll(".legend canvas")) {
    const [c] = cleared(canvas, 16), kind = canvas.dataset.mark;
    if (kind in COLOURS) mark(c, Number(kind), 11, 8);
    if (kind === "path") line(c, [[0, 8], [22, 8]], INK, 2);
    if (kind === "truth") line(c, [[0, 8], [22, 8]], GREY, 1.5, [6, 4]);
    if (kind === "rest") Object.assign(c, {fillStyle: GREY}).fillRect(9.5, 6.5, 3, 3);
  }
  const page = new Page(JSON.parse(document.getElementById("timeline-data").textContent));
  const keys = {ArrowLeft: () => page.show(page.at - 1), ArrowRight: () => page.show(page.at + 1), Home: () => page.show(0), End: () => page.show(Infinity), " ": () => page.play()};
  document.addEventListener("keydown", (event) => {
    const own = event.target.tagName === "BUTTON" && event.key === " ";
    if (!(event.key in keys) || own || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    keys[event.key]();
  });
  page.slider.addEventListener("input", () => page.show(Number(page.slider.value)));
  document.getElementById("back").addEventListener("click", keys.ArrowLeft);
  document.getElementById("on").addEventListener("click", keys.ArrowRight);
  document.getElementById("play").addEventListener("click", () => page.play());
  window.addEventListener("hashchange", () => page.show_address());
  window.addEventListener("resize", () => page.draw());
  page.show_address();
}

try {
  start();
} catch (error) {
  document.documentElement.dataset.error = String(error);
  document.getElementById("state").textContent = `The page could not be drawn: ${error}`;
}
