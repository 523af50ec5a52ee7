// The chart: rows of lanes in groups, one axis for all, two cursors. It only shows and is pointed
// at; what a button or a key does is said in page.js.

import { Axis, neighbour, seconds, snapped, ticks } from "./axis.js";
import { drawLane, drawRules, drawTimes } from "./draw.js";

const ROW = 26;
const CURVE = 58;
const NEAR = 6; // pixels within which a cursor snaps to a change, or is taken by the pointer
const HEAD = { overview: 34, times: 26 };
const APART = 90;
const ROOM = 0.01; // of the whole time, before its begin and behind its end
const COLOURS = ["ink", "soft", "line", "card", "bad", "a", "b", "link", "here"];
const LANES = ["input", "output", "command", "status", "task", "variable", "curve", "rule"];
export const FONT = '11px "DejaVu Sans Mono", Consolas, monospace';

export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

// The colours of the theme, or those of paper.
export function coloursOf(root) {
  const style = getComputedStyle(root);
  const found = { fill: Number(style.getPropertyValue("--fill")) };
  for (const name of [...COLOURS, ...LANES]) found[name] = style.getPropertyValue(`--${name}`).trim();
  return found;
}

// A canvas of so many CSS pixels, sharp on every screen.
export function prepared(canvas, width, height, scale = window.devicePixelRatio || 1) {
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  canvas.style.width = `${width}px`;
  canvas.style.height = `${height}px`;
  const context = canvas.getContext("2d");
  context.scale(scale, scale);
  context.font = FONT;
  return context;
}

export class Chart {
  axis;
  cursors = { a: null, b: null };
  active = "a";
  selected = null;
  still = false;
  onMove = () => {}; // the cursors or the axis are elsewhere
  onSelect = () => {};
  #parts;
  #groups;
  #rows = [];
  #waiting = false;
  #colours;
  #whole = null;

  constructor(root, table, lanes) {
    const find = (id) => root.querySelector(`#${id}`);
    this.#parts = Object.fromEntries(
      ["overview", "times", "rows", "names", "plot"].map((id) => [id, find(id)]),
    );
    this.axis = new Axis(table.begin, table.end, ROOM);
    this.#groups = table.groups.map((one) => ({ ...one, lanes: one.lanes.map((k) => lanes[k]) }));
    this.#point(this.#parts.plot, true);
    this.#point(this.#parts.times, false);
    this.#overview();
    this.#parts.rows.addEventListener("scroll", () => this.draw());
    this.#parts.names.addEventListener("click", (click) => this.#choose(click));
    new ResizeObserver(() => this.draw()).observe(this.#parts.rows);
    this.recolour();
    this.layOut();
  }

  recolour() {
    this.#colours = coloursOf(document.documentElement);
    this.draw();
  }

  // Which rows there are, after a group was opened or closed.
  layOut() {
    this.#rows = [];
    let top = 0;
    for (const group of this.#groups) {
      const shown = group.lanes.filter((lane) => this.still || lane.tells);
      if (!shown.length) continue;
      this.#rows.push({ group, count: shown.length, top, height: ROW });
      top += ROW;
      for (const lane of group.open ? shown : []) {
        this.#rows.push({ lane, top, height: lane.curve ? CURVE : ROW });
        top += this.#rows.at(-1).height;
      }
    }
    this.#parts.names.style.height = `${top}px`;
    this.#parts.names.replaceChildren(...this.#rows.map((row, k) => this.#name(row, k)));
    this.draw();
  }

  #name(row, k) {
    const place = `top:${row.top}px;height:${row.height}px`;
    if (row.group) {
      const { title, open } = row.group;
      const mark = open ? "▾" : "▸";
      const about = { class: "row group", role: "option", id: `row${k}`, "aria-expanded": open, style: place };
      return element("div", about, `${mark} ${title} `, element("small", {}, String(row.count)));
    }
    const { lane } = row;
    const chip = element("i", { style: `background:var(--${lane.colour})` });
    const name = element("span", { class: "name", title: lane.name }, lane.name);
    row.value = element("span", { class: "value" });
    const chosen = lane === this.selected;
    const about = { class: "row", role: "option", id: `row${k}`, "aria-selected": chosen, style: place };
    return element("div", about, chip, name, row.value);
  }

  #choose(click) {
    const at = click.target.closest(".row");
    if (at) this.choose(Number(at.id.slice(3)));
  }

  // Selects the lane of a row, or opens or closes its group.
  choose(k) {
    const row = this.#rows[k];
    if (row?.group) {
      row.group.open = !row.group.open;
      this.layOut();
      this.#here(this.#rows.findIndex((one) => one.group === row.group));
    } else if (row) this.select(row.lane);
  }

  // The row that the keys are at.
  #at = 0;

  #here(k) {
    this.#at = Math.min(Math.max(k, 0), this.#rows.length - 1);
    const { names, rows } = this.#parts;
    names.setAttribute("aria-activedescendant", `row${this.#at}`);
    for (const [place, one] of [...names.children].entries()) one.classList.toggle("at", place === this.#at);
    const { top, height } = this.#rows[this.#at];
    if (top < rows.scrollTop) rows.scrollTop = top;
    if (top + height > rows.scrollTop + rows.clientHeight) rows.scrollTop = top + height - rows.clientHeight;
  }

  // Goes to the row before or behind; on a group, `choose` opens and closes.
  go(by) {
    this.#parts.names.focus({ preventScroll: true });
    this.#here(this.#at + by);
    const row = this.#rows[this.#at];
    if (row.lane) this.select(row.lane);
    else this.onSelect(null, row.group.title);
  }

  chooseHere() {
    if (this.#rows[this.#at]?.group) this.choose(this.#at);
  }

  select(lane) {
    this.selected = lane;
    const group = this.#groups.find((one) => one.lanes.includes(lane));
    if (!group.open) {
      group.open = true;
      this.layOut();
    }
    this.#rows.forEach((row, k) => {
      if (row.group) return;
      this.#parts.names.children[k].setAttribute("aria-selected", row.lane === lane);
      if (row.lane === lane) this.#here(k);
    });
    this.onSelect(lane, lane.name);
    this.draw();
  }

  // Puts a cursor somewhere; with `reveal` it comes into view.
  put(t, which = this.active, reveal = false) {
    this.cursors[which] = Math.round(t);
    if (reveal) this.axis.reveal(t);
    this.draw();
    this.onMove();
  }

  // To the change of the selected lane before or behind the cursor.
  step(direction) {
    const from = this.cursors[this.active] ?? (direction > 0 ? this.axis.from : this.axis.to);
    const t = this.selected && neighbour(this.selected, from, direction);
    if (t !== undefined && t !== null) this.put(t, this.active, true);
    return t;
  }

  zoom(factor, x) {
    this.axis.zoom(factor, x);
    this.draw();
  }

  pan(share) {
    this.axis.pan(this.axis.span * share);
    this.draw();
  }

  show(from, to) {
    this.axis.show(from, to);
    this.draw();
  }

  // All rows, without groups that are closed.
  get openRows() {
    return this.#rows.filter((row) => !row.group || row.group.open);
  }

  #rowsBetween(top, bottom) {
    return this.#rows.filter((row) => row.top < bottom && row.top + row.height > top);
  }

  draw() {
    if (this.#waiting) return;
    this.#waiting = true;
    requestAnimationFrame(() => {
      this.#waiting = false;
      this.#draw();
    });
  }

  #draw() {
    const { rows, names, plot, overview, times } = this.#parts;
    const width = Math.max(rows.clientWidth - names.offsetWidth, 50);
    const height = Math.max(rows.clientHeight, 50);
    this.axis.width = width;
    const top = rows.scrollTop;
    const context = prepared(plot, width, height);
    const marks = ticks(this.axis, APART);
    context.translate(0, -top);
    this.drawRows(context, this.#rowsBetween(top, top + height), marks, this.#colours);
    context.translate(0, top);
    this.#cursorLines(context, this.axis, height);
    const head = prepared(times, width, HEAD.times);
    drawTimes(head, marks, this.axis, HEAD.times, this.#colours, seconds);
    this.#flags(head);
    this.#drawOverview(prepared(overview, width, HEAD.overview), width);
    this.#values(top, top + height);
    const [from, to] = [this.axis.from, this.axis.to].map((t) => seconds(t, marks.step));
    plot.setAttribute("aria-label", `Chart from ${from} to ${to}`);
  }

  // Draws rows, the marks of the time axis behind them.
  drawRows(context, rows, marks, colours, axis = this.axis) {
    for (const { lane, group, top, height } of rows) {
      context.fillStyle = lane && lane === this.selected ? colours.here : group ? colours.line : colours.card;
      context.globalAlpha = group ? 0.45 : 1;
      context.fillRect(0, top, axis.width, height);
      context.globalAlpha = 1;
      context.fillStyle = colours.line;
      context.fillRect(0, top + height - 1, axis.width, 1);
      if (!group) for (const t of marks.times) context.fillRect(Math.round(axis.x(t)), top, 1, height);
    }
    for (const { lane, top, height } of rows) {
      if (lane) drawLane(context, lane, axis, top, height - 1, colours);
    }
  }

  #cursorLines(context, axis, height) {
    const { a, b } = this.cursors;
    if (a !== null && b !== null) {
      context.globalAlpha = 0.1;
      context.fillStyle = this.#colours.link;
      context.fillRect(axis.x(a), 0, axis.x(b) - axis.x(a), height);
      context.globalAlpha = 1;
    }
    const rules = this.#groups.flatMap((group) => group.lanes).find((lane) => lane.colour === "rule");
    if (rules) drawRules(context, rules, axis, height, this.#colours);
    for (const which of ["a", "b"]) {
      if (this.cursors[which] === null) continue;
      context.fillStyle = this.#colours[which];
      context.fillRect(Math.round(axis.x(this.cursors[which])) - 0.5, 0, which === this.active ? 2 : 1, height);
    }
  }

  // The letters of the cursors at the axis.
  #flags(context) {
    for (const which of ["a", "b"]) {
      if (this.cursors[which] === null) continue;
      const x = this.axis.x(this.cursors[which]);
      context.fillStyle = this.#colours[which];
      context.fillRect(x - 7, HEAD.times - 14, 14, 14);
      context.fillStyle = this.#colours.card;
      context.font = `bold ${FONT}`;
      context.fillText(which.toUpperCase(), x - 3, HEAD.times - 3);
      context.font = FONT;
    }
  }

  // The whole run: commands and broken rules, drawn once, and which part of it is shown.
  #drawOverview(context, width) {
    const whole = new Axis(this.axis.begin, this.axis.end);
    whole.width = width;
    if (this.#whole?.width !== width || this.#whole.colours !== this.#colours) {
      const canvas = document.createElement("canvas");
      const drawn = prepared(canvas, width, HEAD.overview);
      const lanes = this.#groups.flatMap((group) => group.lanes);
      const [commands, rules] = ["command", "rule"].map((colour) => lanes.find((lane) => lane.colour === colour));
      if (commands) drawLane(drawn, commands, whole, 10, 18, { ...this.#colours, ink: "transparent" });
      if (rules) drawLane(drawn, rules, whole, 0, 17, this.#colours);
      this.#whole = { width, canvas, colours: this.#colours };
    }
    context.drawImage(this.#whole.canvas, 0, 0, width, HEAD.overview);
    const [from, to] = [whole.x(this.axis.from), whole.x(this.axis.to)];
    context.fillStyle = this.#colours.ink;
    context.globalAlpha = 0.16;
    context.fillRect(0, 0, from, HEAD.overview);
    context.fillRect(to, 0, width - to, HEAD.overview);
    context.globalAlpha = 1;
    context.strokeStyle = this.#colours.link;
    context.lineWidth = 2;
    context.strokeRect(from + 1, 1, Math.max(to - from - 2, 2), HEAD.overview - 2);
  }

  // The values at the active cursor, beside the names.
  #values(top, bottom) {
    const t = this.cursors[this.active];
    this.#parts.names.style.setProperty("--at", `var(--${this.active})`);
    for (const row of this.#rowsBetween(top, bottom)) {
      if (!row.lane || row.lane.colour === "rule") continue;
      const text = t === null ? "" : row.lane.text(row.lane.value(row.lane.indexAt(t)));
      if (row.value.textContent !== text) row.value.textContent = row.value.title = text;
    }
  }

  // The pointer: a click puts a cursor, a cursor can be taken along, what is drawn can be moved; at
  // the axis a part of it can be chosen.
  #point(canvas, moves) {
    let down = null;
    const fingers = new Map(); // where each finger is; two of them zoom
    const xOf = (event) => event.clientX - canvas.getBoundingClientRect().left;
    const taken = (x) =>
      ["a", "b"].find((k) => this.cursors[k] !== null && Math.abs(this.axis.x(this.cursors[k]) - x) < NEAR);
    canvas.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      const x = xOf(event);
      fingers.set(event.pointerId, x);
      canvas.setPointerCapture(event.pointerId);
      if (fingers.size > 1) {
        down = null;
        return;
      }
      down = { x, from: this.axis.from, to: this.axis.to, taken: taken(x), moved: false };
      if (down.taken) this.active = down.taken;
    });
    canvas.addEventListener("pointermove", (event) => {
      const x = xOf(event);
      if (fingers.size > 1) {
        this.#pinch(fingers, event.pointerId, x);
        return;
      }
      if (!down) {
        canvas.style.cursor = taken(x) ? "ew-resize" : "";
        return;
      }
      if (Math.abs(x - down.x) > 3) down.moved = true;
      if (!down.moved) return;
      if (down.taken) this.put(this.#snap(x, event), down.taken);
      else if (moves) {
        const by = ((down.x - x) / this.axis.width) * (down.to - down.from);
        this.show(down.from + by, down.to + by);
      }
    });
    canvas.addEventListener("pointerup", (event) => {
      const from = down;
      down = null;
      fingers.delete(event.pointerId);
      if (!from) return;
      const x = xOf(event);
      if (!from.moved) this.#click(canvas, x, event);
      else if (!moves && !from.taken) {
        const [left, right] = [Math.min(from.x, x), Math.max(from.x, x)];
        this.show(this.axis.t(left), this.axis.t(right));
      }
    });
    canvas.addEventListener("pointercancel", (event) => {
      down = null;
      fingers.delete(event.pointerId);
    });
    canvas.addEventListener(
      "wheel",
      (event) => {
        const along = event.shiftKey ? event.deltaY : event.deltaX;
        if (event.ctrlKey || event.metaKey || (!moves && !event.shiftKey)) {
          this.zoom(1.0015 ** Math.max(-400, Math.min(400, event.deltaY)), xOf(event));
        } else if (Math.abs(along) > 0) this.pan(along / this.axis.width);
        else return; // the rows scroll
        event.preventDefault();
      },
      { passive: false },
    );
  }

  // A finger has moved, another lies still: what was under both stays there.
  #pinch(fingers, which, x) {
    if (!fingers.has(which)) return;
    const [, other] = [...fingers].find(([id]) => id !== which);
    const before = fingers.get(which);
    fingers.set(which, x);
    const apart = Math.abs(x - other);
    if (apart < NEAR || Math.abs(before - other) < NEAR) return;
    this.zoom(Math.abs(before - other) / apart, other);
  }

  #click(canvas, x, event) {
    const which = event.shiftKey ? "b" : this.active;
    const row = canvas === this.#parts.plot ? this.#rowAt(event) : null;
    if (row?.lane) this.select(row.lane);
    this.put(this.#snap(x, event), which);
  }

  #rowAt(event) {
    const y = event.clientY - this.#parts.plot.getBoundingClientRect().top + this.#parts.rows.scrollTop;
    return this.#rows.find((row) => row.top <= y && y < row.top + row.height);
  }

  // Where a cursor goes: to a change that is near, of the lane that is pointed at; with Alt as it is.
  #snap(x, event) {
    const t = this.axis.t(x);
    const lane = this.#rowAt(event)?.lane ?? this.selected;
    if (event.altKey || !lane) return t;
    return snapped([lane], t, (NEAR / this.axis.width) * this.axis.span);
  }

  #overview() {
    const { overview } = this.#parts;
    const go = (event) => {
      const box = overview.getBoundingClientRect();
      const at = this.axis.begin + ((event.clientX - box.left) / box.width) * (this.axis.end - this.axis.begin);
      this.show(at - this.axis.span / 2, at + this.axis.span / 2);
    };
    overview.addEventListener("pointerdown", (event) => {
      overview.setPointerCapture(event.pointerId);
      go(event);
    });
    overview.addEventListener("pointermove", (event) => event.buttons && go(event));
    overview.addEventListener(
      "wheel",
      (event) => {
        this.zoom(1.0015 ** event.deltaY);
        event.preventDefault();
      },
      { passive: false },
    );
  }
}
