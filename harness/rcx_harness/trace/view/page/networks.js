// The drawn networks of the program, with what was energised at a time.
//
// What is true is known from the variables that were recorded. A state is true, false, null where it
// is not known, or undefined where it is not Boolean.

import { element } from "./chart.js";

const OF_BIT = /\.(\d+)$/; // the end of a path to a bit of a variable
const LETTERS = 14; // letters of a value that are shown

const not = (state) => (typeof state === "boolean" ? !state : state);
const truth = (state) => (typeof state === "boolean" ? state : null);
const and = (states) => (states.includes(false) ? false : states.every((one) => one === true) ? true : null);
const or = (states) => not(and(states.map(not)));
const xor = (states) => (states.includes(null) ? null : states.filter(Boolean).length % 2 === 1);
const OPERATORS = { AND: and, OR: or, XOR: xor, NOT: ([state]) => not(state) };
const COMPARISONS = {
  GT: (a, b) => a > b,
  GE: (a, b) => a >= b,
  EQ: (a, b) => a === b,
  LE: (a, b) => a <= b,
  LT: (a, b) => a < b,
  NE: (a, b) => a !== b,
};

// A bit of an integer; a negative one is a two's complement.
export function bitOf(value, bit) {
  if (!Number.isSafeInteger(value)) return undefined;
  return Math.abs(Math.floor(value / 2 ** bit) % 2) === 1;
}

// Whether a comparison holds for each pair of neighbours.
function compared(type, numbers) {
  if (!COMPARISONS[type] || numbers.includes(null)) return null;
  return numbers.slice(1).every((other, k) => COMPARISONS[type](numbers[k], other));
}

// The states of a network: `power(id, pin)` of an output, `symbol(id)` of a contact or coil, `name(id)`
// of an element's variable. `value(path)` says what a variable is: true or false, an integer as a number,
// another value, or undefined where it was not recorded. draw/power.py does the same.
export function statesOf(elements, value) {
  const all = new Map(elements.map((one) => [one.id, one]));
  const found = new Map();
  const known = (path) => (path === null ? null : value(path) ?? null);
  const turned = (state, one) => (one.negated ? not(state) : state);

  // A line that leads back to itself is not known.
  const power = (id, pin = "") => {
    if (id === "") return true; // the left rail
    const key = JSON.stringify([id, pin]);
    if (!found.has(key)) {
      found.set(key, null);
      const one = all.get(id);
      found.set(key, one ? output(one, pin) : null);
    }
    return found.get(key);
  };
  const input = (pin) => {
    if (!pin) return null;
    const states = pin.from.map(([id, name]) => power(id, name));
    const state = states.length === 1 ? states[0] : states.length ? or(states.map(truth)) : pin.always;
    return pin.edge ? null : turned(state, pin);
  };
  const leads = (one) => elements.some((other) => other.in.some(({ from }) => from.some(([id]) => id === one.id)));
  const tested = (one) => {
    const state = one.compare ? compared(one.compare[0], one.compare.slice(1).map(integer)) : truth(known(one.tests));
    return turned(state, one);
  };
  const output = (one, pin) => {
    if (one.number) return undefined;
    if (one.kind === "contact") return and([truth(input(one.in[0])), tested(one)]);
    // Tools differ in what several lines at a coil mean for an element behind it.
    if (one.kind === "coil") return one.in[0].from.length > 1 && leads(one) ? null : input(one.in[0]);
    if (one.kind === "read") return turned(one.always ?? truth(known(one.name)), one);
    if (one.kind === "write") return truth(known(one.name));
    if (one.kind === "connector") return input(one.in[0]);
    if (one.kind === "continuation") {
      const before = elements.find((other) => other.kind === "connector" && other.line === one.line);
      return before ? power(before.id) : null;
    }
    return one.kind === "block" ? ofBlock(one, pin) : null;
  };
  const ofBlock = (one, pin) => {
    const out = one.out.find((other) => other.pin === pin);
    if (!out || out.number) return out ? undefined : null;
    if (out.name !== null) return turned(truth(known(out.name)), out);
    const named = (name) => one.in.find((other) => other.pin.toUpperCase() === name);
    if (pin.toUpperCase() === "ENO") return named("EN") ? turned(input(named("EN")), out) : null;
    // A function that is not executed keeps its result.
    if (named("EN") && input(named("EN")) !== true) return null;
    return turned(result(one.type, one.in.filter((other) => other !== named("EN"))), out);
  };
  // Of a Boolean operator, or of a comparison of integers.
  const result = (type, pins) => {
    if (OPERATORS[type]) return OPERATORS[type](pins.map((pin) => truth(input(pin))));
    return compared(type, pins.map(number));
  };
  const number = (pin) => {
    if (pin.from.length !== 1) return pin.constant;
    const [id, name] = pin.from[0];
    const one = all.get(id);
    return one ? integer(one.out?.find((out) => out.pin === name) ?? one) : null;
  };
  // A constant, or the value of a variable if it is an integer.
  const integer = (part) => {
    const found = part.constant ?? known(part.name ?? null);
    return Number.isSafeInteger(found) ? found : null;
  };
  const symbol = (id) => {
    const one = all.get(id);
    if (one.kind === "contact") return tested(one);
    const state = truth(input(one.in[0]));
    return state ?? (one.stores ? null : turned(truth(known(one.name)), one));
  };
  const name = (id) => {
    const one = all.get(id);
    if (!one || one.name === undefined || one.number) return undefined;
    return one.name === null ? one.always ?? null : known(one.name);
  };
  // The path of a variable whose value is shown.
  const path = (id, pin) => (pin ? all.get(id).out.find((out) => out.pin === pin) : all.get(id)).name;
  return { power, symbol, name, path };
}

export class Networks {
  #groups = [];
  #lanes;
  #variables;

  // `entries` and `variables` as in the table of the page, `lanes` all lanes; `onName(lane)` is called
  // when the name of a variable is clicked.
  constructor(host, entries, variables, lanes, onName) {
    this.#lanes = lanes;
    this.#variables = variables;
    for (const { title, networks } of entries) {
      const box = element("details", { class: "drawn" }, element("summary", {}, title));
      box.open = !this.#groups.length;
      box.addEventListener("toggle", () => this.#draw(group));
      const views = networks.map((network) => this.#view(box, network, onName));
      const group = { box, views, t: null };
      this.#groups.push(group);
      host.append(box);
    }
  }

  #lane(path) {
    const key = path.toUpperCase();
    return this.#lanes[this.#variables[key] ?? this.#variables[key.replace(OF_BIT, "")]];
  }

  #view(box, { title, comment, svg, elements }, onName) {
    const drawing = element("div", {});
    drawing.innerHTML = svg; // made by the program that wrote this page, and escaped there
    box.append(element("h3", {}, title), ...(comment ? [element("p", {}, comment)] : []), drawing);
    const { path } = statesOf(elements, () => undefined);
    const parts = [];
    for (const kind of ["power", "symbol", "name", "value"]) {
      for (const node of drawing.querySelectorAll(`[data-${kind}]`)) {
        const of = JSON.parse(node.dataset[kind]);
        parts.push({ kind, node, of });
        const shown = kind === "name" ? path(of) : kind === "value" ? path(...of) : null;
        const lane = shown ? this.#lane(shown) : null;
        if (!lane) continue;
        const text = node.closest("text");
        text.classList.add("named");
        text.addEventListener("click", () => onName(lane));
      }
    }
    return { elements, parts };
  }

  show(t) {
    for (const group of this.#groups) {
      group.t = t;
      this.#draw(group);
    }
  }

  #draw({ box, views, t }) {
    if (!box.open || t === null) return;
    const value = (path) => {
      const lane = this.#lane(path);
      if (!lane) return undefined;
      const now = lane.value(lane.indexAt(t));
      if (OF_BIT.test(path)) return bitOf(now, Number(OF_BIT.exec(path)[1]));
      return lane.form === "bit" ? Boolean(now) : lane.form === "whole" ? now : lane.text(now);
    };
    const shown = (path) => {
      const lane = this.#lane(path);
      return lane ? lane.text(lane.value(lane.indexAt(t))) : "?";
    };
    for (const { elements, parts } of views) {
      const states = statesOf(elements, value);
      for (const { kind, node, of } of parts) {
        if (kind === "value") {
          const text = shown(states.path(...of));
          node.textContent = text.length > LETTERS ? `${text.slice(0, LETTERS - 1)}…` : text;
          continue;
        }
        const state = kind === "power" ? joined(of.map(([id, pin]) => states.power(id, pin))) : states[kind](of);
        node.classList.toggle("on", state === true);
        node.classList.toggle("unknown", state === null);
      }
    }
  }
}

// The state of a line from several outputs.
function joined(states) {
  return states.length === 1 ? states[0] : or(states.map(truth));
}
