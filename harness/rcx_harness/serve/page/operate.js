// What is done to the controller: switches, alarms, outputs, inputs, workpieces; what is kept of it.

import { element, say } from "./monitor.js";

const $ = (id) => document.getElementById(id);

// `which()` is the number of the controller that is shown.
export class Operate {
  #which;
  #now = null;

  constructor(which) {
    this.#which = which;
    $("stop").addEventListener("click", () => {
      const pressed = this.#now?.switches.emergency_stop;
      this.#happen(pressed ? "emergency_stop_release" : "emergency_stop");
    });
    for (const button of document.querySelectorAll("[data-event]")) {
      button.addEventListener("click", () => this.#happen(button.dataset.event));
    }
    this.#form("alarm", ({ group, category }) =>
      this.#happen("alarm", { group: Number(group.value), category: Number(category.value) }),
    );
    this.#form("parallel", ({ port }, { value }) =>
      this.#happen("parallel_input", { port: Number(port.value), on: Number(value) }),
    );
    this.#form("output", ({ name }, { value }) => {
      const forced = value === "0" || value === "1";
      this.#output(name.value.trim(), forced ? "force" : value, forced ? Number(value) : undefined);
    });
    this.#form("workpiece", ({ axis, pulses }, { value }) =>
      this.#workpiece(Number(axis.value), value === "place" ? Number(pulses.value) : null),
    );
    $("record").addEventListener("click", () =>
      this.#post(`robots/${this.#which()}/recording`, { do: this.#now?.recording.on ? "stop" : "start" }),
    );
    $("begin").addEventListener("click", () => this.#post("stimulus", { do: "begin" }));
    $("recording").addEventListener("click", (click) => {
      if (!$("recording").hasAttribute("href")) click.preventDefault();
    });
  }

  #form(id, act) {
    $(id).addEventListener("submit", (submit) => {
      submit.preventDefault();
      act(submit.target.elements, submit.submitter ?? {});
    });
  }

  // What was refused is said in the card whose button was pressed.
  async #post(path, message) {
    const card = document.activeElement?.closest(".card");
    const place = card?.querySelector(".refused") ?? $("refused");
    const answer = await fetch(`api/${path}`, {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(message),
    }).catch(() => null);
    const error = answer && !answer.ok ? (await answer.json()).error : "";
    say(place, answer ? error : "no answer");
  }

  #happen(event, args = {}) {
    return this.#post(`robots/${this.#which()}/events`, { event, args });
  }

  #output(output, act, value) {
    return this.#post(`robots/${this.#which()}/outputs`, { output, do: act, value });
  }

  #workpiece(axis, pulses) {
    return this.#post(`robots/${this.#which()}/workpieces`, { axis, pulses });
  }

  forget() {
    for (const place of document.querySelectorAll(".refused")) say(place, "");
  }

  show(now) {
    this.#now = now;
    const stop = $("stop");
    stop.setAttribute("aria-pressed", String(now.switches.emergency_stop));
    stop.title = now.switches.emergency_stop ? "pressed: click to release it" : "click to press it";
    for (const field of document.querySelectorAll("[data-switch]")) {
      const state = String(now.switches[field.dataset.switch]);
      for (const button of field.querySelectorAll("[data-when]")) {
        button.setAttribute("aria-pressed", String(button.dataset.when === state));
      }
    }
    this.#chips("held", now.held, (name) => [name, () => this.#output(name, "release")]);
    this.#chips("workpieces", now.workpieces, ({ axis, pulses }) => [
      `axis ${axis}: ${pulses} pulses`,
      () => this.#workpiece(axis, null),
    ]);
    const { on, cycles } = now.recording;
    $("record").setAttribute("aria-pressed", String(on));
    say($("record"), on ? "Stop" : "Start");
    say($("recorded"), on || cycles ? `${cycles} cycles` : "");
    const ready = !on && cycles > 0;
    if (ready) $("recording").href = `api/robots/${now.id}/recording.jsonl`;
    else $("recording").removeAttribute("href");
    $("recording").setAttribute("aria-disabled", String(!ready));
  }

  // A button for each, that takes it away.
  #chips(id, entries, of) {
    const list = $(id);
    const key = JSON.stringify([this.#which(), entries]);
    if (list.dataset.key === key) return;
    list.dataset.key = key;
    list.replaceChildren(
      ...entries.map((entry) => {
        const [text, act] = of(entry);
        const button = element("button", { "aria-label": `${text}: take it away` }, `${text} ✕`);
        button.addEventListener("click", act);
        return element("li", {}, button);
      }),
    );
  }
}
