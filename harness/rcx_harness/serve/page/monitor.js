// The signal monitor, as the vendor's pendant shows it: SI and SO bit by bit, SIW and SOW in
// hexadecimal. Built once per controller; later only what has changed is touched.

const BITS = [7, 6, 5, 4, 3, 2, 1, 0];

export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

// Sets the text of an element only if it is another one.
export function say(target, text) {
  if (target.textContent !== text) target.textContent = text;
}

const hex = (value) => value.toString(16).toUpperCase().padStart(4, "0");

export class Monitor {
  #root;
  #robot = null;
  #cells = new Map();

  constructor(root) {
    this.#root = root;
  }

  show(robot) {
    if (this.#robot !== robot.id) {
      this.#robot = robot.id;
      this.#build(robot);
    }
    for (const kind of ["SI", "SO"]) {
      for (const { port, value } of robot.monitor[kind]) {
        for (const bit of BITS) {
          const cell = this.#cells.get(`${kind}${port}.${bit}`);
          const on = Boolean((value >> bit) & 1);
          say(cell, on ? "●" : "○");
          cell.classList.toggle("on", on);
        }
      }
    }
    for (const kind of ["SIW", "SOW"]) {
      for (const { port, value } of robot.monitor[kind]) {
        const cell = this.#cells.get(`${kind}${port}`);
        say(cell, `&H${hex(value)}`);
        cell.classList.toggle("on", value !== 0);
      }
    }
  }

  #build(robot) {
    this.#cells.clear();
    const titles = new Map();
    for (const one of [...robot.inputs, ...robot.outputs]) titles.set(one.signal, one.title);
    this.#root.replaceChildren(
      this.#bits("SI", robot, titles),
      this.#bits("SO", robot, titles),
      this.#words("SIW", robot),
      this.#words("SOW", robot),
    );
  }

  #bits(kind, robot, titles) {
    const head = element("tr", {}, element("th", {}, "PORT"));
    for (const bit of BITS) head.append(element("th", {}, String(bit)));
    const table = element("table", {}, element("thead", {}, head));
    const body = table.createTBody();
    for (const { port } of robot.monitor[kind]) {
      const row = element("tr", {}, element("th", {}, `${kind} ${port}`));
      for (const bit of BITS) {
        const signal = `${kind}(${port}${bit})`;
        const cell = element("td", { title: `${signal} ${titles.get(signal) ?? ""}`.trim() });
        if (titles.has(signal)) cell.classList.add("named");
        this.#cells.set(`${kind}${port}.${bit}`, cell);
        row.append(cell);
      }
      body.append(row);
    }
    return screen(kind, "●:ON ○:OFF", table);
  }

  #words(kind, robot) {
    const list = element("div", { class: "words" });
    for (const { port } of robot.monitor[kind]) {
      const cell = element("b");
      this.#cells.set(`${kind}${port}`, cell);
      list.append(element("span", {}, `${kind}(${String(port).padStart(2, "0")})`), cell);
    }
    return screen(kind, "hexadecimal", list);
  }
}

function screen(kind, note, content) {
  const head = element("header", {}, `${kind} MONITOR`, element("small", {}, note));
  return element("section", { class: "screen", "aria-label": `${kind} monitor` }, head, content);
}
