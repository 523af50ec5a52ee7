// The timing chart: the server draws it; here are the window, the pause and the cursor.

const CURSOR = "http://www.w3.org/2000/svg";

export class Chart {
  seconds = 10;
  #paused = false;
  #shown = null;
  #root;
  #host;
  #measure;
  #mark = null;
  #at = 1; // of the axis, for the keys

  constructor(host, measure) {
    this.#host = host;
    this.#root = host.attachShadow({ mode: "open" }); // its style sheet stays inside
    this.#measure = measure;
    host.addEventListener("mousemove", (move) => this.#point(move, false));
    host.addEventListener("click", (click) => this.#point(click, true));
    host.addEventListener("mouseleave", () => this.#clear());
    host.addEventListener("keydown", (key) => this.#key(key));
    host.addEventListener("blur", () => this.#clear());
  }

  // Its width [px]: the server draws it so wide, and its text keeps its size.
  get width() {
    return Math.max(200, Math.floor(this.#host.clientWidth));
  }

  // A paused chart stays; but another controller, or another window, is drawn once.
  wants(robot) {
    return !this.#paused || this.#shown !== `${robot} ${this.seconds}`;
  }

  show(robot, svg) {
    this.#shown = `${robot} ${this.seconds}`;
    this.#root.innerHTML = svg;
  }

  tools(windows, pause) {
    const choose = (seconds) => {
      this.seconds = seconds;
      for (const button of windows.children) {
        button.setAttribute("aria-pressed", String(Number(button.dataset.seconds) === seconds));
      }
    };
    for (const button of windows.children) {
      button.addEventListener("click", () => choose(Number(button.dataset.seconds)));
    }
    choose(this.seconds);
    pause.addEventListener("click", () => {
      this.#paused = !this.#paused;
      this.#mark = null;
      pause.setAttribute("aria-pressed", String(this.#paused));
      pause.textContent = this.#paused ? "Go on" : "Pause";
    });
  }

  // The time under the pointer; after a click also the distance from where it was.
  #point(event, click) {
    const svg = this.#root.querySelector("svg");
    if (!svg) return;
    const { left, plot } = svg.dataset;
    const box = svg.getBoundingClientRect();
    const x = ((event.clientX - box.left) * svg.viewBox.baseVal.width) / box.width;
    const share = (x - left) / plot;
    if (share < 0 || share > 1) return this.#clear();
    this.#measureAt(svg, share, click);
  }

  #measureAt(svg, share, click) {
    const { start, span, left, plot } = svg.dataset;
    const time = Number(start) + share * Number(span);
    if (click) this.#mark = time;
    const from = this.#mark === null ? "" : ` (${((time - this.#mark) / 1000).toFixed(0)} ms from the click)`;
    this.#measure.textContent = `${(time / 1e6).toFixed(3)} s${from}`;
    this.#draw(svg, Number(left) + share * Number(plot));
  }

  // Left and right move the cursor, Enter measures from there.
  #key(key) {
    const svg = this.#root.querySelector("svg");
    const by = { ArrowLeft: -1, ArrowRight: 1, Enter: 0 }[key.key];
    if (!svg || by === undefined) return;
    key.preventDefault();
    this.#at = Math.min(1, Math.max(0, this.#at + (by * (key.shiftKey ? 10 : 1)) / 200));
    this.#measureAt(svg, this.#at, key.key === "Enter");
  }

  #draw(svg, x) {
    svg.querySelector(".cursor")?.remove();
    const line = document.createElementNS(CURSOR, "line");
    line.setAttribute("class", "cursor");
    line.setAttribute("stroke", "#c05a00");
    for (const [name, value] of [["x1", x], ["x2", x], ["y1", 20], ["y2", svg.viewBox.baseVal.height]]) {
      line.setAttribute(name, value);
    }
    svg.append(line);
  }

  #clear() {
    this.#measure.textContent = "";
    this.#root.querySelector(".cursor")?.remove();
  }
}
