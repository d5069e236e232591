"use strict";
// The signal of one coordinate runs along s from 0 to 3: s = p between u and theta'', then s = 1 - alpha down to theta.
// Values are stored order by order as whole numbers in units of that order's size, NOTHING where there is none.
const NOTHING = -32768, FULL = 32767 / 2, CLIP = 1.25;
const data = JSON.parse(document.getElementById("data").textContent);
const at = (id) => document.getElementById(id);
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const view = { turn: -0.85, tilt: 0.62, order: 0, playing: 0 };

function decode(text) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return new DataView(bytes.buffer);
}

const cache = new Map();
function wave() {
  const motion = data.motions[at("motion").selectedIndex];
  const key = [motion.name, at("path").value, at("coordinate").value].join("/");
  if (!cache.has(key)) {
    const found = motion.waves[at("path").value][at("coordinate").value];
    const bits = decode(found.values);
    const count = motion.orders.length, times = motion.times;
    const values = new Float32Array(count * times);
    for (let i = 0; i < values.length; i++) {
      const v = bits.getInt16(2 * i, true);
      values[i] = v === NOTHING ? NaN : v / FULL;
    }
    const sorted = Array.from(values.keys()).filter((i) => !Number.isNaN(values[i]))
      .map((i) => Math.abs(values[i]) * found.sizes[Math.floor(i / times)]).sort((a, b) => a - b);
    // The median: half of the surface is drawn below, half above the bend of the asinh.
    const usual = sorted[Math.floor(sorted.length / 2)] || 1;
    cache.set(key, { motion, values, sizes: found.sizes, usual, largest: Math.max(...found.sizes) });
  }
  return cache.get(key);
}

// Height and colour of one sample, between -1 and 1.
function level(w, k, i) {
  const v = w.values[k * w.motion.times + i];
  if (at("height").value === "own") return Math.max(-CLIP, Math.min(CLIP, v));
  return Math.asinh(v * w.sizes[k] / w.usual) / Math.asinh(w.largest / w.usual);
}

// Blue, white, red: the classes of ColorBrewer's RdBu, joined linearly.
const STOPS = [[5, 48, 97], [67, 147, 195], [247, 247, 247], [214, 96, 77], [103, 0, 31]];
function hue(x) {
  if (Number.isNaN(x)) return [128, 128, 128];
  const s = (Math.max(-1, Math.min(1, x)) + 1) * 2, k = Math.min(3, Math.floor(s)), f = s - k;
  return STOPS[k].map((low, c) => Math.round(low + f * (STOPS[k + 1][c] - low)));
}

function canvas(id) {
  const element = at(id), ratio = window.devicePixelRatio || 1, box = element.getBoundingClientRect();
  element.width = Math.round(box.width * ratio);
  element.height = Math.round(box.height * ratio);
  const pen = element.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.font = "13px system-ui, sans-serif";
  return [pen, box.width, box.height];
}

function drawSurface() {
  const [pen, width, height] = canvas("surface"), w = wave(), { motion } = w;
  const [c, s] = [Math.cos(view.turn), Math.sin(view.turn)], [ct, st] = [Math.cos(view.tilt), Math.sin(view.tilt)];
  const size = Math.min(width / 2.9, height / 2.1);
  const project = (x, y, z) => {
    const across = c * x - s * y, away = s * x + c * y;
    return [width / 2 + size * across, height / 2 + size * (-away * st - z * ct) + 8, away];
  };
  const place = (k, i) => {
    const x = 2.2 * (i / (motion.times - 1) - 0.5), y = 1.7 * (motion.orders[k] / 3 - 0.5);
    return project(x, y, 0.38 * (level(w, k, i) || 0));
  };
  const skip = Math.max(1, Math.floor(motion.times / 110)), quads = [];
  for (let k = 0; k + 1 < motion.orders.length; k++) {
    for (let i = 0; i + skip < motion.times; i += skip) {
      if (Number.isNaN(level(w, k, i) + level(w, k + 1, i))) continue;
      const corners = [place(k, i), place(k + 1, i), place(k + 1, i + skip), place(k, i + skip)];
      quads.push([corners.reduce((sum, q) => sum + q[2], 0), corners, hue(level(w, k, i))]);
    }
  }
  quads.sort((a, b) => b[0] - a[0]);
  for (const [, corners, rgb] of quads) {
    pen.fillStyle = pen.strokeStyle = `rgb(${rgb})`;
    pen.beginPath();
    corners.forEach(([x, y], n) => (n ? pen.lineTo(x, y) : pen.moveTo(x, y)));
    pen.closePath(); pen.fill(); pen.stroke();
  }
  pen.strokeStyle = colour("--ink"); pen.lineWidth = 1.6; pen.beginPath();
  for (let i = 0; i < motion.times; i++) {
    const [x, y] = place(view.order, i);
    i ? pen.lineTo(x, y) : pen.moveTo(x, y);
  }
  pen.stroke();
  pen.fillStyle = colour("--soft");
  for (const [words, x, y] of [["t = 0", -1.2, 0], [`t = ${motion.end} s`, 1.2, 0], ["u", 0, -0.97], ["\u03b8", 0, 0.97]]) {
    const [left, top] = project(x, y, -0.38);
    halo(pen, words, left, top);
  }
}

// Words that stay readable in front of the surface.
function halo(pen, words, left, top) {
  pen.textAlign = "center"; pen.lineJoin = "round"; pen.lineWidth = 4; pen.strokeStyle = colour("--paper");
  pen.strokeText(words, left, top); pen.fillText(words, left, top);
}

function drawMap() {
  const [pen, width, height] = canvas("map"), w = wave(), { motion } = w;
  const [left, top, right, low] = [34, 6, width - 8, height - 24];
  const picture = new ImageData(motion.times, 300);
  for (let y = 0; y < 300; y++) {
    const s = 3 * y / 299;
    let k = motion.orders.findIndex((order) => order >= s);
    k = k < 1 ? 1 : k;
    const f = (s - motion.orders[k - 1]) / (motion.orders[k] - motion.orders[k - 1]);
    for (let i = 0; i < motion.times; i++) {
      const value = level(w, k - 1, i) * (1 - f) + level(w, k, i) * f;
      picture.data.set([...hue(value), Number.isNaN(value) ? 0 : 255], 4 * (y * motion.times + i));
    }
  }
  const sheet = document.createElement("canvas");
  [sheet.width, sheet.height] = [motion.times, 300];
  sheet.getContext("2d").putImageData(picture, 0, 0);
  pen.drawImage(sheet, left, top, right - left, low - top);
  const down = (s) => top + (low - top) * s / 3;
  pen.strokeStyle = pen.fillStyle = colour("--soft"); pen.lineWidth = 0.7; pen.textAlign = "right";
  for (const [s, words] of [[0, "u"], [1, "\u03b8\u2033"], [2, "\u03b8\u2032"], [3, "\u03b8"]]) {
    pen.fillText(words, left - 6, Math.min(low, Math.max(top + 10, down(s) + 4)));
    if (s === 1) { pen.beginPath(); pen.moveTo(left, down(s)); pen.lineTo(right, down(s)); pen.stroke(); }
  }
  axis(pen, motion, left, right, low);
  pen.strokeStyle = colour("--ink"); pen.lineWidth = 1.6; pen.beginPath();
  pen.moveTo(left, down(motion.orders[view.order])); pen.lineTo(right, down(motion.orders[view.order])); pen.stroke();
}

function axis(pen, motion, left, right, low) {
  pen.fillStyle = colour("--soft"); pen.textAlign = "center";
  for (let n = 0; n <= 4; n++) {
    pen.fillText(`${+(motion.end * n / 4).toPrecision(3)}${n === 4 ? " s" : ""}`, left + (right - left) * n / 4 - (n === 4 ? 8 : 0), low + 17);
  }
}

function drawCurve() {
  const [pen, width, height] = canvas("curve"), w = wave(), { motion } = w, k = view.order;
  const [left, top, right, low] = [70, 8, width - 8, height - 24];
  const y = (v) => (top + low) / 2 - (low - top) / 2 * Math.max(-1, Math.min(1, v / CLIP));
  pen.strokeStyle = colour("--line"); pen.beginPath(); pen.moveTo(left, y(0)); pen.lineTo(right, y(0)); pen.stroke();
  pen.fillStyle = colour("--soft"); pen.textAlign = "right";
  for (const v of [-1, 0, 1]) pen.fillText((v * w.sizes[k]).toPrecision(3), left - 8, y(v) + 4);
  axis(pen, motion, left, right, low);
  pen.strokeStyle = colour("--accent"); pen.lineWidth = 1.6; pen.beginPath();
  let drawing = false;
  for (let i = 0; i < motion.times; i++) {
    const v = w.values[k * motion.times + i];
    if (Number.isNaN(v)) { drawing = false; continue; }
    const x = left + (right - left) * i / (motion.times - 1);
    drawing ? pen.lineTo(x, y(v)) : pen.moveTo(x, y(v));
    drawing = true;
  }
  pen.stroke();
  const s = motion.orders[k], order = s <= 1 ? `p = ${s.toFixed(3)}` : `\u03b1 = ${(1 - s).toFixed(3)}`;
  const whole = at("path").value === "total" && data.initial ? "\u03c8, D^\u03b1 \u03b8\u2033 with its initial terms" : "D^\u03b1 \u03b8\u2033";
  const what = s <= 1 ? "(I\u207b\u00b9)^p u" : whole;
  at("reading").textContent = `${motion.coordinates[at("coordinate").value]} at ${order}: ${what}, up to ${w.sizes[k].toPrecision(3)} in SI units`;
}

function draw() { drawSurface(); drawMap(); drawCurve(); }

function choices(id, entries) {
  const element = at(id), kept = element.value;
  element.replaceChildren(...entries.map(([value, words]) => new Option(words, value)));
  if (entries.some(([value]) => String(value) === kept)) element.value = kept;
}

function changed() {
  const motion = data.motions[at("motion").selectedIndex];
  choices("coordinate", motion.coordinates.map((name, k) => [k, name]));
  choices("path", Object.keys(motion.waves).map((path) => [path, data.paths[path]]));
  at("order").max = motion.orders.length - 1;
  view.order = Math.min(view.order, motion.orders.length - 1);
  draw();
}

function choose(order) { view.order = order; at("order").value = order; draw(); }

function step() {
  if (!view.playing) return;
  const last = data.motions[at("motion").selectedIndex].orders.length - 1;
  choose(view.order >= last ? 0 : view.order + 1);
  view.playing = window.setTimeout(step, 80);
}

choices("motion", data.motions.map((motion, k) => [k, motion.name]));
for (const id of ["motion", "coordinate", "path", "height"]) at(id).addEventListener("change", changed);
at("order").addEventListener("input", () => choose(+at("order").value));
at("play").addEventListener("click", () => {
  window.clearTimeout(view.playing);
  view.playing = view.playing ? 0 : window.setTimeout(step, 0);
  at("play").textContent = view.playing ? "Pause" : "Play";
});
at("map").addEventListener("pointerdown", (event) => {
  const box = at("map").getBoundingClientRect(), s = 3 * (event.clientY - box.top - 6) / (box.height - 30);
  const orders = data.motions[at("motion").selectedIndex].orders;
  choose(orders.reduce((best, order, k) => (Math.abs(order - s) < Math.abs(orders[best] - s) ? k : best), 0));
});
at("surface").addEventListener("pointermove", (event) => {
  if (!event.buttons) return;
  view.turn += event.movementX / 150;
  view.tilt = Math.max(0.1, Math.min(1.5, view.tilt + event.movementY / 200));
  drawSurface();
});
window.addEventListener("resize", draw);
changed();
