// Runs the script of a viewer page in a document made of stubs, works every control, and prints what the page reads.
// node viewer_dom.js PAGE.html
"use strict";
const page = require("fs").readFileSync(process.argv[2], "utf8");
const scripts = [...page.matchAll(/<script[^>]*>([\s\S]*?)<\/script>/g)].map((match) => match[1]);
const strokes = { fill: 0, stroke: 0, fillText: 0, putImageData: 0, drawImage: 0 };
const bad = [];
const pen = new Proxy({}, {
  get: (kept, name) => name in kept ? kept[name] : (...given) => {
    if (name in strokes) strokes[name] += 1;
    if (given.some((value) => typeof value === "number" && !Number.isFinite(value))) bad.push([name, given]);
  },
  set: (kept, name, value) => { kept[name] = value; return true; },
});
class Element {
  constructor() { Object.assign(this, { value: "", textContent: "", options: [], listeners: {}, max: 0 }); }
  get selectedIndex() { return Math.max(0, this.options.findIndex((option) => String(option.value) === String(this.value))); }
  replaceChildren(...options) { this.options = options; this.value = options.length ? String(options[0].value) : ""; }
  addEventListener(kind, listener) { this.listeners[kind] = listener; }
  getBoundingClientRect() { return { width: 600, height: 300, top: 0, left: 0 }; }
  getContext() { return pen; }
  fire(kind, event = {}) { this.listeners[kind](event); }
}
const elements = {};
const document = {
  getElementById: (id) => (elements[id] = elements[id] || new Element()),
  createElement: () => new Element(), documentElement: {},
};
const timers = [];
const window = { devicePixelRatio: 1, addEventListener: () => {}, setTimeout: (work) => timers.push(work), clearTimeout: () => {} };
const Option = class { constructor(words, value) { this.words = words; this.value = value; } };
const ImageData = class { constructor(width, height) { this.data = new Uint8ClampedArray(4 * width * height); } };
const getComputedStyle = () => ({ getPropertyValue: () => "#000" });
document.getElementById("data").textContent = scripts[0];
document.getElementById("height").value = "own";
new Function("document", "window", "Option", "ImageData", "getComputedStyle", scripts[1])(
  document, window, Option, ImageData, getComputedStyle);
const readings = [elements.reading.textContent];
const note = () => readings.push(elements.reading.textContent);
elements.order.value = elements.order.max; elements.order.fire("input"); note();
for (const id of ["motion", "coordinate", "path"]) {
  const select = elements[id];
  select.value = String(select.options[select.options.length - 1].value); select.fire("change"); note();
}
elements.height.value = "asinh"; elements.height.fire("change");
elements.map.fire("pointerdown", { clientY: 100 }); note();
elements.surface.fire("pointermove", { buttons: 1, movementX: 40, movementY: -30 });
elements.play.fire("click");
for (let n = 0; n < 3; n++) timers.shift()();
note();
console.log(JSON.stringify({ readings, strokes, bad }));
