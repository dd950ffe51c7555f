// Motions side by side, counted in frames of their file, with stretches of time to look at.

const shown = JSON.parse(document.getElementById("data").textContent);
const BEFORE = 0.5; // seconds to see before a stretch

class MotionPlayer extends Player {
  constructor(box, figure, spans) {
    super(box, figure, { words: { ...WORDS, clock: "frame {frame}, {seconds} s" } });
    this.spans = spans;
    const step = (label, text, by) => {
      const button = element("button", { type: "button", className: "step", ariaLabel: label, title: label }, text);
      button.addEventListener("click", () => {
        this.pause();
        this.seek(Math.max(0, Math.min(this.frames - 1, this.frame + by)));
      });
      return button;
    };
    const speeds = [1, 0.5, 0.25].map((value) => element("option", { value }, `${value}`));
    this.speeds = element("select", {}, ...speeds);
    this.speeds.addEventListener("change", () => {
      this.speed = Number(this.speeds.value);
      if (this.started !== null) this.play();
    });
    this.button.after(
      step("One picture back", "\u2039", -1),
      step("One picture on", "\u203a", 1),
      element("label", { className: "speed" }, "Speed", this.speeds),
    );
    this.track = element("span", { className: "track" });
    this.slider.replaceWith(this.track);
    this.track.append(this.slider);
  }

  show(panels) {
    super.show(panels);
    const last = Math.max(1, this.frames - 1) / this.figure.fps;
    const place = (seconds) => `calc(.5rem + ${Math.min(1, seconds / last)} * (100% - 1rem))`; // where the thumb goes
    for (const [start, end] of this.spans) {
      const mark = element("span", { className: "span" });
      mark.style.left = place(start);
      mark.style.right = `calc(100% - ${place(end)})`;
      this.track.append(mark);
    }
    if (this.spans.length > 0) this.jump(this.spans[0][0]);
  }

  // Go to shortly before a time, and go on as before.
  jump(seconds) {
    const playing = this.started !== null;
    this.pause();
    this.seek(Math.max(0, Math.min(this.frames - 1, Math.round((seconds - BEFORE) * this.figure.fps))));
    if (playing) this.play();
  }

  count(frame) {
    const seconds = frame / this.figure.fps;
    const within = this.spans.some(([start, end]) => start <= seconds && seconds < end);
    this.box.classList.toggle("within", within);
    return { frame: Math.round(seconds * this.figure.rate), seconds: seconds.toFixed(2) };
  }
}

const player = new MotionPlayer(document.getElementById("player"), shown.figure, shown.spans);
player.show(shown.panels);
for (const line of document.querySelectorAll("[data-span]")) {
  line.addEventListener("click", () => {
    player.jump(shown.spans[line.dataset.span][0]);
    player.play();
    player.box.scrollIntoView({ block: "nearest" });
  });
}
