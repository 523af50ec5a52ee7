// The robot programs of a recording, with the line of each task as it is at a time.

import { element } from "./chart.js";
import { ListingView } from "./listing.js";

// Where each program is at a time: task, line and state by its name. `texts` says so for each text
// of a lane, `tasks` has a task's number and its lane.
export function placesAt({ tasks, texts }, t) {
  const found = new Map();
  for (const [task, lane] of tasks) {
    const [program, line, state] = texts[lane.value(lane.indexAt(t))] ?? [];
    if (program !== undefined) found.set(program, { task, line, state });
  }
  return found;
}

// The next time behind t at which a line of a program is executed, and the lane of its task; from
// the beginning where there is none. null where it never is.
export function nextTime({ tasks, texts }, program, line, t) {
  const times = [];
  for (const [, lane] of tasks) {
    for (let k = 0; k < lane.times.length; k++) {
      const [name, at, state] = texts[lane.value(k)] ?? [];
      if (name === program && at === line && state === "running") times.push({ t: lane.times[k], lane });
    }
  }
  times.sort((one, other) => one.t - other.t);
  return times.find((one) => one.t > t) ?? times[0] ?? null;
}

export class Programs {
  #controllers;

  // `entries` as in the table of the page, `lanes` all lanes; `onLine(entry, program, line)` is
  // called when a line is clicked.
  constructor(host, entries, lanes, onLine) {
    this.#controllers = entries.map((entry) => {
      const own = { ...entry, tasks: entry.tasks.map(([number, lane]) => [number, lanes[lane]]) };
      if (entry.title) host.append(element("h2", {}, entry.title));
      const used = new Set(Object.values(entry.texts).map(([program]) => program));
      const views = entry.programs
        .filter(({ lines }) => lines.length)
        .map((program) => {
          const view = new ListingView(host, program, (line) => onLine(own, program.name, line));
          view.open = used.has(program.name);
          return { name: program.name, view };
        });
      return { own, views };
    });
    const many = this.#controllers.reduce((sum, { views }) => sum + views.length, 0);
    host.classList.toggle("several", many > 1);
  }

  show(t) {
    for (const { own, views } of this.#controllers) {
      const places = placesAt(own, t);
      for (const { name, view } of views) view.show(places.get(name) ?? null);
    }
  }
}
