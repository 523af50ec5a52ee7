// The stimulus: a row with a time slider for each moment, and the buttons that add a row.

const FAULTS = [
  ["Emergency stop", 'robot = "emergency_stop", for = "500ms"', "pressed for 500 ms"],
  ["Link down", 'robot = "link_down", for = "300ms"', "the cable is unplugged for 300 ms"],
  ["Alarm 12.600", 'robot = { event = "alarm", group = 12, category = 600 }', "a serious alarm"],
  ["Controller off and on", 'robot = "power_cycle"', "a power cycle of the controller"],
  ["Manual mode", 'robot = "manual_mode", for = "500ms"', "MANUAL mode for 500 ms"],
  ["Programming box", 'robot = "pendant_on", for = "500ms"', "takes control authority for 500 ms"],
  ["Lost packets", 'robot = { event = "packets_lost", share = 0.3 }, for = "500ms"', "30 % of the packets for 500 ms"],
  ["PLC stop", 'plc = "stop", for = "500ms"', "the PLC is in STOP for 500 ms"],
  ["Set a variable", 'set = { "Main.Start" = true }, for = "100ms"', "sets a variable; edit the row"],
];
const STEP = 10_000; // step of the sliders [us]

const seek = (id) => document.getElementById(id);
export const seconds = (us) => `${(us / 1e6).toFixed(2)} s`;

export class Moments {
  /** `changed` is called when a moment is added, removed, moved or changed. */
  constructor(changed) {
    this.changed = changed;
    this.rows = [];
    this.end = 0;
    this.at = slider("Inject at", 0, 1, STEP, 0, () => {});
    const buttons = FAULTS.map(([name, text, about]) => {
      const button = document.createElement("button");
      button.textContent = name;
      button.title = about;
      button.onclick = () => this.add(text);
      return button;
    });
    seek("faults").replaceChildren(this.at.label, ...buttons);
  }

  load(rows, end) {
    this.rows = rows.map((row) => [...row]);
    this.at.set(end / 2, end);
    this.last(end);
  }

  /** Set the end of the run, which limits the sliders. */
  last(end) {
    this.end = end;
    this.at.set(Math.min(this.at.value, end), end);
    this.draw();
  }

  add(text) {
    this.rows.push([this.at.value, text]);
    this.rows.sort((one, other) => one[0] - other[0]);
    this.draw();
    this.changed();
  }

  /** Mark a row, and show its error. */
  mark(wrong) {
    this.draw(wrong);
  }

  draw(wrong = null) {
    const rows = this.rows.map((row, at) => {
      const item = document.createElement("li");
      const when = slider("", 0, Math.max(this.end, row[0]), STEP, row[0], (value) => {
        row[0] = value;
        this.changed();
      });
      when.input.ariaLabel = `Time of ${row[1]}`;
      const what = document.createElement("input");
      what.value = row[1];
      what.ariaLabel = "What happens";
      what.spellcheck = false;
      what.onchange = () => {
        row[1] = what.value;
        this.changed();
      };
      const gone = document.createElement("button");
      gone.textContent = "×";
      gone.ariaLabel = `Remove ${row[1]}`;
      gone.onclick = () => {
        this.rows.splice(at, 1);
        this.draw();
        this.changed();
      };
      item.append(when.label, what, gone);
      if (wrong?.moment === at) {
        item.className = "bad";
        const note = document.createElement("p");
        note.textContent = wrong.message;
        item.append(note);
      }
      return item;
    });
    seek("moments").replaceChildren(...rows);
  }
}

/** Return a slider with its name and value; `changed` is called when the slider is released. */
export function slider(name, least, most, step, value, changed, shown = seconds) {
  const label = document.createElement("label");
  label.className = "slider";
  const input = document.createElement("input");
  const output = document.createElement("output");
  Object.assign(input, { type: "range", min: least, max: most, step });
  input.value = value;
  const told = () => (output.textContent = shown(one.value));
  const one = {
    label,
    input,
    get value() { return Number(input.value); },
    set(to, most) {
      if (most !== undefined) input.max = most;
      input.value = to;
      told();
    },
  };
  input.oninput = told;
  input.onchange = () => changed(one.value);
  told();
  label.append(name, input, output);
  return one;
}
