// A robot program: its lines as written, and the line that its task executes.
//
// Takes nothing from elsewhere. The page gives what rcx_harness/robot/listing.py says as JSON:
//
//   const view = new ListingView(host, { title, lines }, (line) => ...);   // a line was clicked
//   view.show({ task, line, state });     // again and again; null: the program is in no task
//
// host   a block element
// state  ready, running, stopped, suspended or ended: of a task that is ready or has ended no line
//        is marked
//
// Colours are the page's: --ink, --soft, --line, --link, --a. A listing is at most --listing-high.

const LISTING_STYLE = `
.listing summary { display: flex; flex-wrap: wrap; gap: 0 10px; padding: 3px 0; cursor: pointer; }
.listing summary b { overflow-wrap: anywhere; }
.listing summary::before { content: "▸"; }
.listing[open] summary::before { content: "▾"; }
.listing summary span { color: var(--soft, #566371); font-variant-numeric: tabular-nums; }
.listing .lines {
  position: relative; max-height: var(--listing-high, 300px); overflow: auto; padding: 2px 0; scrollbar-width: thin;
  border: 1px solid var(--line, #d7dee6); border-radius: 5px;
  font: 12px/18px "DejaVu Sans Mono", Consolas, monospace;
}
.listing .lines > div { width: max-content; min-width: 100%; }
.listing .lines > div > div {
  padding-right: 8px; content-visibility: auto; contain-intrinsic-size: auto 18px; white-space: pre;
}
.listing .asked > div > div { cursor: pointer; }
.listing i {
  display: inline-block; width: calc(var(--digits) * 1ch + 3ch); margin-right: 1ch; padding-right: .6ch;
  border-right: 1px solid var(--line, #d7dee6); color: var(--soft, #566371); font-style: normal; text-align: right;
}
.listing .comment { color: var(--soft, #566371); }
.listing [data-state] { --mark: var(--link, #1a62ab); background: color-mix(in srgb, var(--mark) 17%, transparent); box-shadow: inset 3px 0 var(--mark); }
.listing [data-state="stopped"], .listing [data-state="suspended"] { --mark: var(--a, #b34f00); }
.listing [data-state] i { color: var(--mark); font-weight: bold; }
.listing [data-state] i::before { content: "▶"; float: left; margin-left: 1ch; }
.listing [data-state="stopped"] i::before, .listing [data-state="suspended"] i::before { content: "‖"; }
`;

const IN_LINE = ["running", "stopped", "suspended"];

function listingElement(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

// Where the comment of a line begins; its length where it has none.
export function commentAt(text) {
  let quoted = false;
  for (let k = 0; k < text.length; k++) {
    if (text[k] === '"') quoted = !quoted;
    else if (text[k] === "'" && !quoted) return k;
  }
  return /^\s*REM\b/i.test(text) ? 0 : text.length;
}

// Where a task is, in words.
export function placeText(place) {
  if (!place) return "in no task";
  const { task, line, state } = place;
  return IN_LINE.includes(state) ? `task ${task}, line ${line}, ${state}` : `task ${task}, ${state}`;
}

export class ListingView {
  #box;
  #lines;
  #said;
  #here = null;

  constructor(host, { title, lines }, onLine = null) {
    if (!document.getElementById("listing-style")) {
      document.head.append(listingElement("style", { id: "listing-style" }, LISTING_STYLE));
    }
    this.#said = listingElement("span");
    const rows = listingElement("div");
    lines.forEach((text, k) => {
      const at = commentAt(text);
      const row = listingElement("div", {}, listingElement("i", {}, String(k + 1)), text.slice(0, at));
      if (at < text.length) row.append(listingElement("span", { class: "comment" }, text.slice(at)));
      rows.append(row);
    });
    const about = { class: "lines", tabindex: "0", role: "group", "aria-label": `Lines of ${title}` };
    this.#lines = listingElement("div", { ...about, style: `--digits:${String(lines.length).length}` }, rows);
    if (onLine) {
      this.#lines.classList.add("asked");
      this.#lines.title = "Click a line: the next time that it is executed";
      rows.addEventListener("click", (click) => {
        const row = click.target.closest(".lines > div > div");
        if (row) onLine([...rows.children].indexOf(row) + 1);
      });
    }
    const summary = listingElement("summary", {}, listingElement("b", {}, title), this.#said);
    this.#box = listingElement("details", { class: "listing", open: "" }, summary, this.#lines);
    this.#box.addEventListener("toggle", () => this.#reveal());
    host.append(this.#box);
  }

  set open(open) {
    this.#box.open = open;
  }

  show(place) {
    const said = placeText(place);
    if (this.#said.textContent === said) return;
    this.#said.textContent = said;
    this.#here?.removeAttribute("data-state");
    this.#here?.removeAttribute("aria-current");
    const marked = place && IN_LINE.includes(place.state);
    this.#here = marked ? this.#lines.firstChild.children[place.line - 1] ?? null : null;
    if (!this.#here) return;
    this.#here.setAttribute("data-state", place.state);
    this.#here.setAttribute("aria-current", "true");
    this.#reveal();
  }

  // The line comes into sight, with some lines before it.
  #reveal() {
    const [box, row] = [this.#lines, this.#here];
    if (!row || !box.clientHeight) return;
    const top = row.offsetTop;
    if (top < box.scrollTop || top + row.offsetHeight > box.scrollTop + box.clientHeight) {
      box.scrollTop = Math.max(0, top - box.clientHeight / 3);
    }
  }
}
