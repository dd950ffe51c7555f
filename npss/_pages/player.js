"use strict";
// Moving skeletons on separate canvases that play in step and turn together.

const DISTANCE = 6000; // of the camera, in millimetres
const GRID = 400; // distance between the lines of the floor, in millimetres
const HOLD = 0.6; // seconds at the last frame before the motion starts again

function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

// Fill in the words in braces of a text.
function fill(text, words) {
  return text.replaceAll(/\{(\w+)\}/g, (braces, word) => words[word] ?? braces);
}

const WORDS = {
  ...{ play: "Play", pause: "Pause", time: "Time", clock: "{now} of {end} ms", view: "View" },
  figure: "Moving skeleton: {name}",
};

// Positions of joints, x y z, frame after frame: millimetres as 16-bit integers, lowest byte first.
function unpack(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Int16Array(bytes.buffer);
}

class Player {
  // `figure` holds fps and bones, each (child, parent, side); `words` are the texts of the controls.
  constructor(box, figure, { abreast = false, words = WORDS } = {}) {
    this.figure = figure;
    this.words = words;
    const children = new Set(figure.bones.map(([child]) => child));
    this.root = figure.bones.map(([, parent]) => parent).find((joint) => !children.has(joint)) ?? 0;
    this.joints = 1 + Math.max(0, ...figure.bones.flatMap(([child, parent]) => [child, parent]));
    this.panels = [];
    this.frame = null;
    this.frames = 0;
    this.yaw = 50; // degrees; 0 faces the viewer, 90 looks to the right
    this.pitch = 8;
    this.started = null; // time of frame 0 on the clock of the animation; null while paused
    this.speed = 1;

    this.box = element("div", { className: abreast ? "panels abreast" : "panels" });
    this.button = element("button", { type: "button" });
    this.slider = element("input", { type: "range", min: 0, step: 1 });
    this.clock = element("output");
    this.view = element("input", { type: "range", min: -180, max: 180, step: 5, value: this.yaw });
    const controls = element(
      "div",
      { className: "controls" },
      this.button,
      element("label", { className: "time" }, words.time, this.slider, this.clock),
      element("label", { className: "view" }, words.view, this.view),
    );
    box.append(this.box, controls);

    this.button.addEventListener("click", () => (this.started === null ? this.play() : this.pause()));
    this.slider.addEventListener("input", () => {
      this.pause();
      this.seek(Number(this.slider.value));
    });
    this.view.addEventListener("input", () => this.turn(Number(this.view.value), this.pitch));
    this.resized = new ResizeObserver(() => this.draw());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());
    this.pause();
  }

  // Show motions from their beginning: panels of {label, truth, motion}.
  show(panels) {
    this.resized.disconnect();
    this.panels = panels.map(({ label, truth, motion }) => {
      const canvas = element("canvas", { role: "img", ariaLabel: fill(this.words.figure, { name: label }) });
      this.drag(canvas);
      this.resized.observe(canvas);
      return { label, truth, canvas, motion: unpack(motion) };
    });
    this.box.replaceChildren(
      ...this.panels.map(({ label, truth, canvas }) =>
        element("figure", { className: truth ? "truth" : "" }, element("figcaption", {}, label), canvas),
      ),
    );
    this.frames = Math.max(...this.panels.map(({ motion }) => motion.length / this.joints / 3));
    this.slider.max = this.frames - 1;
    this.measure();
    this.frame = null; // nothing is drawn yet
    this.seek(0);
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) this.pause();
    else this.play();
  }

  play() {
    if (this.frame === this.frames - 1) this.seek(0);
    this.button.textContent = this.words.pause;
    this.started = undefined; // set by the first animation frame
    cancelAnimationFrame(this.request);
    const rate = this.figure.fps * this.speed;
    const tick = (now) => {
      this.started ??= now - (this.frame / rate) * 1000;
      const elapsed = (now - this.started) / 1000;
      if (elapsed * rate >= this.frames + HOLD * rate) this.started = now;
      this.seek(Math.min(this.frames - 1, Math.max(0, Math.floor(((now - this.started) / 1000) * rate))));
      this.request = requestAnimationFrame(tick);
    };
    this.request = requestAnimationFrame(tick);
  }

  pause() {
    cancelAnimationFrame(this.request);
    this.started = null;
    this.button.textContent = this.words.play;
  }

  seek(frame) {
    if (frame === this.frame) return;
    this.frame = frame;
    const time = (index) => Math.round(((index + 1) * 1000) / this.figure.fps);
    this.clock.value = fill(this.words.clock, { now: time(frame), end: time(this.frames - 1), ...this.count(frame) });
    this.slider.value = frame;
    this.slider.ariaValueText = this.clock.value;
    this.draw();
  }

  // More words for the clock.
  count() {
    return {};
  }

  turn(yaw, pitch) {
    this.yaw = ((((yaw + 180) % 360) + 360) % 360) - 180;
    this.pitch = Math.max(-10, Math.min(60, pitch));
    this.view.value = this.yaw;
    this.draw();
  }

  drag(canvas) {
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (!canvas.hasPointerCapture(event.pointerId)) return;
      this.turn(this.yaw + event.movementX / 2, this.pitch + event.movementY / 4);
    });
  }

  // The place of the root above the floor, which the view follows.
  place(motion, frame) {
    const at = 3 * (frame * this.joints + this.root);
    return [motion[at], motion[at + 2]];
  }

  // Measure the space that all motions need from any direction of view.
  measure() {
    this.floor = Infinity;
    this.top = -Infinity;
    this.reach = 1;
    for (const { motion } of this.panels) {
      for (let i = 0; i < motion.length; i += 3) {
        const [x, z] = this.place(motion, Math.floor(i / 3 / this.joints));
        this.floor = Math.min(this.floor, motion[i + 1]);
        this.top = Math.max(this.top, motion[i + 1]);
        this.reach = Math.max(this.reach, Math.hypot(motion[i] - x, motion[i + 2] - z));
      }
    }
  }

  draw() {
    if (this.panels.length === 0) return;
    const style = getComputedStyle(this.box);
    const colour = (name) => style.getPropertyValue(`--${name}`);
    for (const panel of this.panels) this.drawPanel(panel, colour);
  }

  drawPanel({ canvas, motion, truth }, colour) {
    const ratio = devicePixelRatio || 1;
    const width = canvas.clientWidth;
    const height = canvas.clientHeight;
    if (!width || !height) return;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const context = canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);

    const scale = 0.92 * Math.min(height / (this.top - this.floor + 250), width / (2 * this.reach));
    const [sinYaw, cosYaw] = [Math.sin((this.yaw * Math.PI) / 180), Math.cos((this.yaw * Math.PI) / 180)];
    const [sinPitch, cosPitch] = [Math.sin((this.pitch * Math.PI) / 180), Math.cos((this.pitch * Math.PI) / 180)];
    const middle = (this.top + this.floor) / 2;
    const frame = Math.min(this.frame, motion.length / this.joints / 3 - 1);
    const [rootX, rootZ] = this.place(motion, frame);
    // x to the right, y down; nearer points are larger.
    const project = (x, y, z) => {
      const across = (x - rootX) * cosYaw + (z - rootZ) * sinYaw;
      const ahead = (z - rootZ) * cosYaw - (x - rootX) * sinYaw;
      const up = (y - middle) * cosPitch - ahead * sinPitch;
      const near = (y - middle) * sinPitch + ahead * cosPitch;
      const size = (scale * DISTANCE) / Math.max(DISTANCE - near, 1);
      return [width / 2 + across * size, height / 2 - up * size, near];
    };
    const line = (from, to) => {
      context.beginPath();
      context.moveTo(from[0], from[1]);
      context.lineTo(to[0], to[1]);
      context.stroke();
    };

    context.strokeStyle = colour("line");
    context.lineWidth = 1;
    const [gridX, gridZ] = [Math.round(rootX / GRID) * GRID, Math.round(rootZ / GRID) * GRID];
    for (let at = -2 * GRID; at <= 2 * GRID; at += GRID) {
      line(project(gridX + at, this.floor, gridZ - 2 * GRID), project(gridX + at, this.floor, gridZ + 2 * GRID));
      line(project(gridX - 2 * GRID, this.floor, gridZ + at), project(gridX + 2 * GRID, this.floor, gridZ + at));
    }

    // The path of the root so far, on the floor.
    context.strokeStyle = colour("muted");
    context.lineWidth = 2;
    context.lineCap = "butt"; // nothing for a root that stays in its place
    context.beginPath();
    for (let past = 0; past <= frame; past++) {
      const [x, z] = this.place(motion, past);
      context.lineTo(...project(x, this.floor, z).slice(0, 2));
    }
    context.stroke();

    const joints = [];
    for (let j = 0; j < this.joints; j++) {
      const at = 3 * (frame * this.joints + j);
      joints.push(project(motion[at], motion[at + 1], motion[at + 2]));
    }
    const far = (bone) => joints[bone[0]][2] + joints[bone[1]][2];
    context.lineWidth = Math.max(2.5, 40 * scale);
    context.lineCap = "round";
    // From far to near; where bones coincide, as spine and collarbones, the first is visible.
    for (const bone of this.figure.bones.toReversed().sort((a, b) => far(a) - far(b))) {
      context.strokeStyle = colour(`${truth ? "truth" : "motion"}-${bone[2]}`);
      line(joints[bone[0]], joints[bone[1]]);
    }
  }
}
