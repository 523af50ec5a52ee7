// The page: its data, its buttons and keys, the list of events, and what goes onto paper.

import { Axis, duration, seconds, ticks } from "./axis.js";
import { Chart, coloursOf, element, prepared } from "./chart.js";
import { Events, Lane, unpack } from "./data.js";
import { drawTimes } from "./draw.js";
import { Networks } from "./networks.js";
import { Player } from "./play.js";
import { Programs, nextTime } from "./programs.js";
import { Robots } from "./robots.js";
import { find, step } from "./search.js";

const ZOOM = 0.5;
const EVENT = 24; // height of an event in the list
const LONGEST = 8e6; // pixels that a list may be high: what browsers can scroll
const AROUND = 300_000; // shown before and behind what was found, at least [us]
const [HIGH, LOW] = [220, 140]; // of a view of a robot, alone and above its programs [px]
const WHILE_PLAYING = [" ", "+", "=", "-", "0", "t"]; // keys that do not end playing
const SCROLLS = ["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight", "PageUp", "PageDown", "Home", "End"]; // a listing
const PAPER = { width: 1030, height: 590, head: 26, names: 290, scale: 3, most: 300 }; // A4 in CSS pixels
const KINDS = {
  rule: "rules",
  command: "commands",
  input: "inputs",
  output: "outputs",
  task: "robot programs",
  variable: "variables",
};
const KEYS = [
  ["+ −", "show less or more time, at the cursor"],
  ["0", "show all"],
  ["← →", "move along the time axis; with Shift further"],
  ["Home End", "to the beginning, to the end"],
  ["↑ ↓", "choose a signal; Enter opens or closes a group"],
  [", .", "cursor to the change of the signal before, to the next one"],
  ["Space", "play the run from the cursor on, or pause it"],
  ["a b", "which cursor moves; a click puts it, Shift and click puts B"],
  ["c", "show what is between the cursors"],
  ["n p", "next broken rule, the one before"],
  ["/", "search; Enter goes to the next event, Shift and Enter to the one before"],
  ["t", "light or dark"],
  ["Ctrl wheel", "zoom; Shift and wheel moves; drag along the axis to choose a part"],
  ["Alt", "with a click or a drag: the cursor does not snap to a change"],
];

const DARK = matchMedia("(prefers-color-scheme: dark)");
const embedded = Boolean(document.documentElement.dataset.theme);
const isDark = () => document.documentElement.dataset.theme === "dark";
const byId = (id) => document.getElementById(id);

class Page {
  #chart;
  #events;
  #lanes;
  #table;
  #found = new Int32Array();
  #place = -1;
  #hidden = new Set(["task", "variable"]);
  #robots;
  #programs;
  #networks;
  #player;
  #waits = false;

  constructor(table, bytes) {
    this.#table = table;
    this.#lanes = [];
    for (const [k, entry] of table.lanes.entries()) {
      this.#lanes.push(new Lane(entry, k, bytes, this.#lanes, table.texts, table.cycle));
    }
    this.#events = new Events(this.#lanes, bytes, table.order);
    this.#chart = new Chart(document, table, this.#lanes);
    byId("robots").hidden = !table.robots.length;
    const high = table.programs.length ? LOW : HIGH;
    this.#robots = new Robots(byId("robots").querySelector("div"), table.robots, this.#lanes, high);
    byId("programs").hidden = !table.programs.length;
    byId("programs").parentElement.classList.toggle("programmed", table.programs.length > 0);
    const host = byId("programs").querySelector("div");
    this.#programs = new Programs(host, table.programs, this.#lanes, (...line) => this.#toLine(...line));
    byId("networks").hidden = !table.networks.length;
    const drawn = byId("networks").querySelector("div");
    this.#networks = new Networks(drawn, table.networks, table.variables, this.#lanes, (lane) => this.#chart.select(lane));
    this.#player = new Player(
      (frame) => requestAnimationFrame(frame),
      (t) => this.#playedTo(t),
      () => (byId("play").textContent = this.#player.playing ? "❚❚ Pause" : "▶ Play"),
    );
    this.#chart.onMove = () => this.#read();
    this.#chart.onSelect = (lane, name) => (byId("selected").textContent = name);
    byId("about").textContent = table.about;
    this.#rules();
    this.#kinds();
    this.#buttons();
    this.#keys();
    this.#search();
    this.#read();
    window.addEventListener("beforeprint", () => this.#print());
    window.addEventListener("afterprint", () => byId("paper").replaceChildren());
    // A page that embeds this one sets `data-theme` and sends its changes; else the system decides.
    if (embedded) {
      const changed = ({ data }) => data?.theme && this.#dress(data.theme === "dark");
      window.addEventListener("message", changed);
    } else DARK.addEventListener("change", () => this.#dress(DARK.matches));
  }

  // The button that leads to what was broken.
  #rules() {
    const { broken } = this.#table;
    const button = byId("rules");
    button.hidden = !broken;
    button.textContent = broken === 1 ? "1 rule broken ▸" : `${broken} rules broken ▸`;
    button.title = "Next broken rule (n)";
    button.addEventListener("click", () => this.#toRule(1));
  }

  #toRule(direction) {
    const lane = this.#lanes.find((one) => one.colour === "rule");
    if (!lane) return;
    const rules = find(this.#events, "", (one) => one === lane);
    const here = this.#current();
    const at = rules.indexOf(here);
    const place =
      at >= 0
        ? (at + direction + rules.length) % rules.length
        : step(this.#events, rules, this.#chart.cursors.a ?? -1, direction);
    this.#hidden.delete("rule");
    this.#openAll();
    this.#goTo(rules[place]);
  }

  // The list shows all again, so that what is looked for is in it.
  #openAll() {
    if (!byId("search").value && !this.#hidden.has("rule")) return;
    byId("search").value = "";
    this.#search();
  }

  #kinds() {
    for (const [kind, title] of Object.entries(KINDS)) {
      if (!this.#lanes.some((lane) => kindOf(lane) === kind && !lane.curve && lane.count)) continue;
      const box = element("input", { type: "checkbox" });
      box.checked = !this.#hidden.has(kind);
      box.addEventListener("change", () => {
        if (box.checked) this.#hidden.delete(kind);
        else this.#hidden.add(kind);
        this.#search();
      });
      byId("kinds").append(element("label", {}, box, title));
    }
  }

  #buttons() {
    const chart = this.#chart;
    const on = (id, act) => byId(id).addEventListener("click", act);
    on("in", () => this.#zoom(ZOOM));
    on("out", () => this.#zoom(1 / ZOOM));
    on("fit", () => chart.show(chart.axis.begin, chart.axis.end));
    on("play", () => this.#play());
    byId("pace").addEventListener("change", () => {
      if (!this.#player.playing) return;
      this.#player.stop();
      this.#play();
    });
    for (const canvas of ["plot", "times", "list"]) {
      byId(canvas).addEventListener("pointerdown", () => this.#player.stop());
    }
    on("a", () => this.#activate("a"));
    on("b", () => this.#activate("b"));
    on("before", () => chart.step(-1));
    on("behind", () => chart.step(1));
    on("theme", () => this.#dress(!isDark()));
    on("print", () => window.print());
    on("help", () => byId("keys").showModal());
    on("up", () => this.#go(-1));
    on("down", () => this.#go(1));
    byId("still").addEventListener("change", (change) => {
      chart.still = change.target.checked;
      chart.layOut();
    });
    byId("keys").querySelector("dl").append(
      ...KEYS.flatMap(([keys, about]) => [
        element("dt", {}, ...keys.split(" ").map((key) => element("kbd", {}, key))),
        element("dd", {}, about),
      ]),
    );
    byId("search").addEventListener("input", () => this.#search());
    const list = byId("list");
    list.addEventListener("scroll", () => this.#list());
    new ResizeObserver(() => this.#list()).observe(list);
    list.addEventListener("click", (click) => {
      const at = click.target.closest(".event");
      if (at) this.#take(Number(at.dataset.place));
    });
  }

  #zoom(factor) {
    const { axis, cursors, active } = this.#chart;
    const x = cursors[active] === null ? undefined : axis.x(cursors[active]);
    this.#chart.zoom(factor, x >= 0 && x <= axis.width ? x : undefined);
  }

  // Plays on from the cursor; from the beginning if there is no cursor or it is at the end.
  #play() {
    if (this.#player.playing) return this.#player.stop();
    const { begin, end } = this.#table;
    const { cursors, active } = this.#chart;
    const at = cursors[active];
    const from = at === null || at >= end ? begin : at;
    this.#player.start(from, end, Number(byId("pace").value));
  }

  // The cursor goes along; where it leaves what is shown, the next part is shown.
  #playedTo(now) {
    const { axis } = this.#chart;
    const { end, step } = this.#table;
    const t = now < end ? now - (now % step) : end; // as exact as the times that were recorded
    if (t < axis.from || t > axis.to) axis.show(t, t + axis.span);
    this.#chart.put(t);
  }

  #activate(which) {
    this.#chart.active = which;
    if (this.#chart.cursors[which] === null) {
      this.#chart.put((this.#chart.axis.from + this.#chart.axis.to) / 2);
    }
    this.#chart.draw();
    this.#read();
  }

  #dress(dark) {
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    this.#chart.recolour();
  }

  #keys() {
    document.addEventListener("keydown", (key) => {
      if (byId("keys").open || key.ctrlKey || key.metaKey || key.altKey) return;
      const at = key.target;
      if (at.matches(".lines, #networks > div") && SCROLLS.includes(key.key)) return;
      if (at === byId("search")) this.#searchKey(key);
      else if (at === byId("list") && this.#listKey(key)) key.preventDefault();
      else if (this.#key(key, at)) key.preventDefault();
    });
  }

  #searchKey(key) {
    if (key.key === "Enter") this.#go(key.shiftKey ? -1 : 1);
    if (key.key !== "Escape") return;
    key.target.value = "";
    this.#search();
    byId("names").focus();
  }

  #listKey({ key }) {
    const by = { ArrowDown: 1, ArrowUp: -1, PageDown: 10, PageUp: -10 }[key];
    if (!by || !this.#found.length) return false;
    this.#take(Math.min(Math.max(this.#place + by, 0), this.#found.length - 1));
    return true;
  }

  // What a key does; of a button, Enter and space are its own.
  #key({ key, shiftKey }, at) {
    const chart = this.#chart;
    const { axis } = chart;
    const far = shiftKey ? 0.8 : 0.15;
    const acts = {
      "+": () => this.#zoom(ZOOM),
      "=": () => this.#zoom(ZOOM),
      "-": () => this.#zoom(1 / ZOOM),
      0: () => chart.show(axis.begin, axis.end),
      ArrowLeft: () => chart.pan(-far),
      ArrowRight: () => chart.pan(far),
      Home: () => chart.show(axis.begin, axis.begin + axis.span),
      End: () => chart.show(axis.end - axis.span, axis.end),
      ArrowUp: () => chart.go(-1),
      ArrowDown: () => chart.go(1),
      ",": () => chart.step(-1),
      ".": () => chart.step(1),
      a: () => this.#activate("a"),
      b: () => this.#activate("b"),
      " ": () => this.#play(),
      c: () => this.#between(),
      n: () => this.#toRule(1),
      p: () => this.#toRule(-1),
      t: () => this.#dress(!isDark()),
      "/": () => byId("search").focus(),
      "?": () => byId("keys").showModal(),
    };
    if (key === "Enter" && at === byId("names")) acts.Enter = () => chart.chooseHere();
    // A focused button, box or list takes the space bar itself.
    const isOwn = key === " " && at.matches("button, input, select, summary");
    const act = isOwn ? null : acts[key];
    if (act && !WHILE_PLAYING.includes(key)) this.#player.stop();
    if (act) act();
    return Boolean(act);
  }

  #between() {
    const { a, b } = this.#chart.cursors;
    if (a === null || b === null || a === b) return;
    const room = Math.abs(b - a) * 0.1;
    this.#chart.show(Math.min(a, b) - room, Math.max(a, b) + room);
  }

  // A time as exact as those that were recorded.
  #time(t) {
    return seconds(t, t % this.#table.step ? 1 : this.#table.step);
  }

  // What the cursors say.
  #read() {
    const { cursors, active } = this.#chart;
    for (const which of ["a", "b"]) {
      const button = byId(which);
      button.setAttribute("aria-pressed", String(which === active));
      button.querySelector("output").textContent = cursors[which] === null ? "–" : this.#time(cursors[which]);
    }
    const { a, b } = cursors;
    byId("between").querySelector("output").textContent = a === null || b === null ? "–" : duration(b - a);
    this.#move();
  }

  // To the next time at which a line of a robot program is executed.
  #toLine(controller, program, line) {
    const { cursors, active } = this.#chart;
    const next = nextTime(controller, program, line, cursors[active] ?? -1);
    if (!next) return;
    this.#player.stop();
    this.#chart.select(next.lane);
    this.#chart.put(next.t, active, true);
  }

  // Robots, programs and networks are shown as at the cursor that moves; without one as at the end.
  #move() {
    const { robots, programs, networks } = this.#table;
    if (this.#waits || !(robots.length || programs.length || networks.length)) return;
    this.#waits = true;
    requestAnimationFrame(() => {
      this.#waits = false;
      const { cursors, active } = this.#chart;
      const t = cursors[active];
      const when = t === null ? "at the end" : `at ${this.#time(t)}`;
      for (const small of document.querySelectorAll(".when")) small.textContent = when;
      this.#robots.show(t ?? this.#table.end);
      this.#programs.show(t ?? this.#table.end);
      this.#networks.show(t ?? this.#table.end);
    });
  }

  #search() {
    const here = this.#current();
    const query = byId("search").value;
    this.#found = find(this.#events, query, (lane) => !this.#hidden.has(kindOf(lane)) || query.trim());
    const many = this.#found.length;
    const at = this.#found.indexOf(here);
    this.#place = at;
    byId("count").textContent = `${many.toLocaleString("en")} ${many === 1 ? "event" : "events"}${query.trim() ? " found" : ""}`;
    byId("long").style.height = `${Math.min(many * EVENT, LONGEST)}px`;
    if (at >= 0) this.#scrollTo(at);
    this.#list();
  }

  #current() {
    return this.#found[this.#place];
  }

  // To the next event that was found, or to the one before it.
  #go(direction) {
    const many = this.#found.length;
    if (!many) return;
    const t = this.#chart.cursors[this.#chart.active] ?? -1;
    const place =
      this.#place >= 0 && this.#events.time(this.#current()) === t
        ? (this.#place + direction + many) % many
        : step(this.#events, this.#found, t, direction);
    this.#take(place);
  }

  #goTo(event) {
    const place = this.#found.indexOf(event);
    if (place >= 0) this.#take(place);
  }

  // An event was chosen: the cursor goes there, its signal is selected, its text is read in full.
  #take(place) {
    this.#place = place;
    const event = this.#current();
    const lane = this.#events.lane(event);
    const t = this.#events.time(event);
    const { axis } = this.#chart;
    if (axis.span > (axis.end - axis.begin) * 0.5 && axis.end - axis.begin > 4 * AROUND) {
      const around = Math.max(AROUND, (axis.end - axis.begin) * 0.002);
      axis.show(t - around, t + around);
    }
    this.#chart.select(lane);
    this.#chart.put(t, this.#chart.active, true);
    this.#scrollTo(place);
    this.#list();
    const section = this.#table.sections[lane.value(this.#events.which[event])];
    const whole = byId("whole");
    whole.classList.toggle("rule", lane.colour === "rule");
    whole.replaceChildren(element("b", {}, this.#time(t)), this.#events.text(event));
    if (lane.colour === "rule" && section) whole.append(` (${section.startsWith("docs/") ? section : `manual: ${section}`})`);
  }

  // The list is as long as a browser can scroll; where there are more events, a pixel is several.
  #pitch() {
    return Math.min(EVENT, LONGEST / Math.max(this.#found.length, 1));
  }

  #scrollTo(place) {
    const list = byId("list");
    const top = place * this.#pitch();
    const low = list.scrollTop + list.clientHeight - 2 * EVENT;
    if (top < list.scrollTop || top > low) list.scrollTop = top - list.clientHeight / 2;
  }

  #list() {
    const list = byId("list");
    const first = Math.max(0, Math.floor(list.scrollTop / this.#pitch()) - 2);
    const last = Math.min(this.#found.length, first + Math.ceil(list.clientHeight / EVENT) + 4);
    const rows = [];
    for (let place = first; place < last; place++) {
      const event = this.#found[place];
      const lane = this.#events.lane(event);
      const top = first * this.#pitch() + (place - first) * EVENT;
      const chosen = place === this.#place;
      const about = { class: `event ${lane.colour}`, role: "option", "data-place": place, style: `top:${top}px` };
      const row = element("div", { ...about, id: `event${place}`, "aria-selected": chosen });
      row.title = this.#events.text(event);
      row.append(element("time", {}, this.#time(this.#events.time(event))), element("span", {}, row.title));
      rows.push(row);
    }
    byId("long").replaceChildren(...rows);
    if (this.#place >= 0) list.setAttribute("aria-activedescendant", `event${this.#place}`);
  }

  // Onto paper goes the part of the time that is seen, all open rows, and its events.
  #print() {
    const chart = this.#chart;
    const axis = new Axis(chart.axis.begin, chart.axis.end);
    axis.width = PAPER.width - PAPER.names;
    [axis.from, axis.to] = [chart.axis.from, chart.axis.to];
    const marks = ticks(axis, 80);
    const paper = byId("paper");
    const { a, b } = chart.cursors;
    const cursors = ["a", "b"].filter((k) => chart.cursors[k] !== null).map((k) => `${k.toUpperCase()} ${this.#time(chart.cursors[k])}`);
    if (a !== null && b !== null) cursors.push(`A to B ${duration(b - a)}`);
    const range = `${seconds(axis.from, marks.step)} to ${seconds(axis.to, marks.step)}`;
    paper.replaceChildren(
      element("h1", {}, this.#table.title),
      element("p", {}, [range, ...cursors, this.#table.about].join(" · ")),
    );
    if (byId("robots").open) paper.append(...[...document.querySelectorAll("#robots .rv")].map(copied));
    const colours = paperColours();
    const sheets = [[]];
    let top = 0;
    for (const row of chart.openRows) {
      if (top + row.height > PAPER.height) {
        sheets.push([]);
        top = 0;
      }
      sheets.at(-1).push({ ...row, top });
      top += row.height;
    }
    paper.append(...sheets.map((rows) => this.#sheet(rows, axis, marks, colours)));
    paper.append(this.#eventsOnPaper(axis));
  }

  #sheet(rows, axis, marks, colours) {
    const canvas = document.createElement("canvas");
    const height = rows.reduce((sum, row) => sum + row.height, PAPER.head);
    const context = prepared(canvas, PAPER.width, height, PAPER.scale);
    context.fillStyle = "#fff";
    context.fillRect(0, 0, PAPER.width, height);
    context.save();
    context.beginPath();
    context.rect(PAPER.names, 0, axis.width, height);
    context.clip();
    context.translate(PAPER.names, 0);
    drawTimes(context, marks, axis, PAPER.head, colours, seconds);
    context.translate(0, PAPER.head);
    this.#chart.drawRows(context, rows, marks, colours, axis);
    context.restore();
    context.fillStyle = colours.ink;
    for (const { lane, group, top, height: tall } of rows) {
      context.font = `${group ? "bold " : ""}11px "DejaVu Sans", Arial, sans-serif`;
      const text = group ? group.title : lane.name;
      context.fillText(text, group ? 0 : 10, top + PAPER.head + tall / 2 + 4, PAPER.names - 16);
    }
    for (const which of ["a", "b"]) {
      const x = axis.x(this.#chart.cursors[which] ?? NaN);
      if (!(x >= 0 && x <= axis.width)) continue;
      context.fillStyle = colours[which];
      context.fillRect(PAPER.names + x, 12, 1, height);
      context.fillText(which.toUpperCase(), PAPER.names + x + 3, 22);
    }
    return canvas;
  }

  #eventsOnPaper(axis) {
    const table = document.createElement("table");
    const events = [...this.#found].filter((k) => this.#events.time(k) >= axis.from && this.#events.time(k) <= axis.to);
    for (const event of events.slice(0, PAPER.most)) {
      const kind = this.#events.lane(event).colour;
      const time = this.#time(this.#events.time(event));
      table.append(element("tr", { class: kind }, element("td", {}, time), element("td", {}, this.#events.text(event))));
    }
    if (events.length > PAPER.most) {
      table.append(element("tr", {}, element("td"), element("td", {}, `and ${events.length - PAPER.most} more events`)));
    }
    return table;
  }
}

// Commands and what the controller answers to them are looked at together.
function kindOf(lane) {
  return lane.colour === "status" ? "command" : lane.colour;
}

// A drawing for paper; what clips it has to be its own, for the one on the screen is hidden.
function copied(drawing) {
  const copy = drawing.cloneNode(true);
  copy.innerHTML = copy.innerHTML.replace(/\brv(\d+)(above|side)\b/g, "paper$1$2");
  return copy;
}

// The colours of the light theme, whatever the screen shows.
function paperColours() {
  const root = document.documentElement;
  const before = root.dataset.theme;
  root.dataset.theme = "light";
  const colours = { ...coloursOf(root), here: "#fff" };
  root.dataset.theme = before;
  return colours;
}

async function start() {
  const failed = byId("failed");
  if (typeof DecompressionStream === "undefined") {
    failed.textContent = "This browser is too old for this page: use one of 2023 or newer.";
    failed.hidden = false;
    return;
  }
  document.documentElement.dataset.theme ||= DARK.matches ? "dark" : "light";
  const { table, bytes } = await unpack(byId("data").textContent);
  new Page(table, bytes);
  // Drawn for the first time: so many milliseconds after it was asked for.
  requestAnimationFrame(() => setTimeout(() => (document.documentElement.dataset.ready = Math.round(performance.now()))));
}

start();
