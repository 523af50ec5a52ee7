// Shows the files of a program one at a time, with colours, and each error at the end of its line.

const WORDS = new Set(
  ("ABSTRACT AND ARRAY AT BEGIN BY CASE CONFIGURATION CONSTANT CONTINUE DO ELSE ELSIF END_CASE "
  + "END_CONFIGURATION END_FOR END_FUNCTION END_FUNCTION_BLOCK END_IF END_METHOD END_PROGRAM END_REPEAT "
  + "END_RESOURCE END_STRUCT END_TYPE END_VAR END_WHILE EXIT EXTENDS FALSE FINAL FOR FUNCTION "
  + "FUNCTION_BLOCK IF INTERVAL METHOD MOD NON_RETAIN NOT OF ON OR PRIORITY PROGRAM REPEAT RESOURCE "
  + "RETAIN RETURN STRUCT TASK THEN TO TRUE TYPE UNTIL VAR VAR_EXTERNAL VAR_GLOBAL VAR_INPUT VAR_IN_OUT "
  + "VAR_OUTPUT VAR_TEMP WHILE WITH XOR").split(" "),
);
const PARTS = /(\(\*[^]*?(?:\*\)|$)|\/\/.*)|('(?:[^'$\n]|\$.)*'?)|(\b[A-Za-z_]+#[\w.:+-]+|\b\d[\w.#]*)|([A-Za-z_]\w*)/g;
const TOML = /(#.*)|("(?:[^"\\\n]|\\.)*"?)|(\b\d[\w.-]*)|(^\s*\[.*\])/gm;

const seek = (id) => document.getElementById(id);

export class Editor {
  /** `changed` is called after each change of a text. */
  constructor(changed) {
    this.files = {};
    this.shown = "";
    this.wrong = null;
    this.edit = seek("edit");
    this.edit.addEventListener("input", () => {
      this.files[this.shown] = this.edit.value;
      if (this.wrong?.file === this.shown) this.wrong = null;
      this.draw();
      changed();
    });
    this.edit.addEventListener("keydown", (event) => {
      if (event.key !== "Tab" || event.shiftKey || event.ctrlKey || this.leaving) {
        this.leaving = event.key === "Escape"; // after Escape, Tab leaves the editor
        return;
      }
      event.preventDefault();
      document.execCommand("insertText", false, "  ");
    });
    seek("tabs").addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (!step) return;
      const names = Object.keys(this.files);
      this.show(names[(names.indexOf(this.shown) + step + names.length) % names.length]);
      seek("tabs").querySelector("[aria-selected=true]").focus();
    });
  }

  /** Replace the files, and show the first file. */
  load(files, first) {
    this.files = { ...files };
    this.wrong = null;
    this.show(first);
  }

  show(name) {
    this.shown = name;
    this.edit.value = this.files[name];
    seek("text").scrollTo(0, 0);
    this.draw();
  }

  /** Mark a line and scroll to it; null removes the mark. */
  mark(wrong) {
    this.wrong = wrong;
    if (wrong && wrong.file in this.files) this.show(wrong.file);
    else this.draw();
    if (!wrong?.line) return;
    const high = this.edit.offsetHeight / this.edit.rows;
    seek("text").scrollTo(0, Math.max(0, high * (wrong.line - 4)));
  }

  draw() {
    const text = this.edit.value;
    const lines = text.split("\n");
    const wrong = this.wrong?.file === this.shown ? this.wrong : null;
    this.edit.style.width = `calc(${Math.max(...lines.map((line) => line.length)) + 2}ch + 12px)`;
    this.edit.rows = lines.length + 1;
    const mirror = seek("mirror");
    mirror.replaceChildren(...coloured(text, this.shown.endsWith(".toml") ? TOML : PARTS));
    if (wrong?.line) this.say(mirror, lines, wrong);
    const numbers = lines.map((_, at) => {
      const one = document.createElement("span");
      one.textContent = `${at + 1}\n`;
      one.className = wrong?.line === at + 1 ? "bad" : "";
      return one;
    });
    seek("numbers").replaceChildren(...numbers);
    this.tabs();
  }

  /** Show the error after the end of its line. */
  say(mirror, lines, wrong) {
    const note = document.createElement("span");
    note.className = "note";
    note.style.top = `${wrong.line - 1}lh`;
    note.style.left = `${(lines[wrong.line - 1] ?? "").length + 2}ch`;
    note.textContent = `◂ ${wrong.message}`;
    mirror.append(note);
  }

  tabs() {
    const tabs = Object.keys(this.files).map((name) => {
      const tab = document.createElement("button");
      tab.textContent = name;
      tab.role = "tab";
      tab.ariaSelected = name === this.shown;
      tab.tabIndex = name === this.shown ? 0 : -1;
      tab.className = this.wrong?.file === name ? "bad" : "";
      tab.onclick = () => this.show(name);
      return tab;
    });
    seek("tabs").replaceChildren(...tabs);
  }
}

function coloured(text, parts) {
  const found = [];
  let end = 0;
  const plain = (to) => to > end && found.push(document.createTextNode(text.slice(end, to)));
  for (const match of text.matchAll(parts)) {
    const kind = match[1] ? "c" : match[2] ? "s" : match[3] ? "n" : parts === TOML || WORDS.has(match[4].toUpperCase()) ? "k" : "";
    if (!kind) continue;
    plain(match.index);
    end = match.index + match[0].length;
    const span = document.createElement("span");
    span.className = kind;
    span.textContent = match[0];
    found.push(span);
  }
  plain(text.length);
  return found;
}
