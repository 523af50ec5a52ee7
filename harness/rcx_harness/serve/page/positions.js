// Where the robots are: their drawings, and each axis in pulses and mm with its last minute.

import { element, say } from "./monitor.js";
import { RobotView } from "./robot.js";

const MINUTE_US = 60e6;
const MOST = 400; // samples of a minute
const MOST_WAY = 1500; // positions of the trail: 30 s of motion
const TREND = { width: 160, height: 26 };
const SPACE = "http://www.w3.org/2000/svg";

export class Positions {
  #drawings;
  #rows;
  #shown = "";
  #views = [];
  #past = [];
  #trails = [];
  #until = -1; // time of the last position in the trails [us]

  constructor(drawings, rows) {
    this.#drawings = drawings;
    this.#rows = rows;
  }

  // Another model is needed where it is of another controller, or has changed.
  wants({ id, drawn }) {
    return this.#shown !== `${id} ${drawn}`;
  }

  model({ id }, { robots, drawn }) {
    const same = this.#shown.split(" ")[0] === String(id) && this.#views.length === robots.length;
    this.#shown = `${id} ${drawn}`;
    if (same) {
      robots.forEach((model, k) => (this.#views[k].model = model));
      return;
    }
    this.#past = [];
    this.#trails = robots.map(() => []);
    this.#until = -1;
    this.#views = [];
    this.#drawings.replaceChildren();
    for (const model of robots) {
      const box = element("div", { class: "drawing" });
      const title = `Robot ${model.robot}${model.name ? `: ${model.name}` : ", without a type in its file"}`;
      this.#drawings.append(element("h3", {}, title), box);
      this.#views.push(new RobotView(box, model, { unit: "pulses", high: 300 }));
    }
    this.#rows.replaceChildren();
  }

  show({ t_us, positions, mm, way, poses, titles }) {
    const fresh = way.filter(([t]) => t > this.#until);
    this.#until = Math.max(this.#until, ...fresh.map(([t]) => t));
    if (this.#past.length && this.#past.at(-1).t > t_us) this.#past = [];
    this.#past.push({ t: t_us, mm });
    while (this.#past.length > MOST || this.#past[0].t < t_us - MINUTE_US) this.#past.shift();
    let begin = 0;
    this.#views.forEach((view, k) => {
      const from = begin;
      const own = positions.slice(from, (begin += view.model.axes.length));
      const trail = this.#trails[k];
      // All positions since the last time, so that the trail is as smooth as the motion.
      for (const pulses of [...fresh.map(([, ...all]) => all.slice(from, begin)), own]) {
        const place = view.place(pulses, poses[k]);
        if (place && String(place) !== String(trail.at(-1))) trail.push(place);
      }
      trail.splice(0, trail.length - MOST_WAY);
      view.show(own, poses[k], trail);
    });
    if (this.#rows.children.length !== titles.length) this.#build(titles);
    titles.forEach((_, k) => this.#row(this.#rows.children[k], k, positions[k], mm[k], t_us));
  }

  #build(titles) {
    this.#rows.replaceChildren(
      ...titles.map(({ axis, place }) => {
        const svg = document.createElementNS(SPACE, "svg");
        const box = { viewBox: `0 0 ${TREND.width} ${TREND.height}`, preserveAspectRatio: "none" };
        for (const [name, value] of Object.entries({ ...TREND, ...box, class: "trend", "aria-hidden": "true" })) {
          svg.setAttribute(name, value);
        }
        svg.append(document.createElementNS(SPACE, "path"));
        const value = element("td", { class: "number" });
        return element("tr", {}, element("th", { scope: "row" }, axis), element("td", { class: "number" }),
          element("td", {}, place), value, element("td", {}, svg));
      }),
    );
  }

  #row(row, k, pulses, value, now) {
    say(row.cells[1], String(pulses));
    say(row.cells[3], value.toFixed(3));
    const values = this.#past.map((one) => one.mm[k]);
    const [low, high] = [Math.min(...values), Math.max(...values)];
    const { width, height } = TREND;
    const x = (t) => width - 2 - ((now - t) / MINUTE_US) * (width - 4);
    const y = (one) => (high > low ? height - 4 - ((one - low) / (high - low)) * (height - 8) : height / 2);
    const d = this.#past.map(({ t, mm }, at) => `${at ? "L" : "M"}${x(t).toFixed(1)} ${y(mm[k]).toFixed(1)}`).join("");
    row.querySelector("path").setAttribute("d", d);
    row.cells[4].title = `${low.toFixed(3)} to ${high.toFixed(3)}`;
  }
}
