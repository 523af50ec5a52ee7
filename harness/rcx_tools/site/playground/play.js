// The page: a program, the settings of its run, and the chart of the run (rcx view).
import { Editor } from "./editor.js";
import { Moments, seconds, slider } from "./moments.js";
import { packed, unpacked } from "./share.js";
import { onTheme, theme } from "./theme.js";

const FIRST = "04_scara";
const RPI = 10_000;
const MS = 1000;

const seek = (id) => document.getElementById(id);
const milliseconds = (us) => `${us / MS} ms`;

const programs = fetch("programs.json").then((answer) => answer.json());
const editor = new Editor(() => (dirty = true));
const moments = new Moments(soon);
const sliders = {
  scan: slider("Scan", 1 * MS, 50 * MS, MS, 10 * MS, soon, milliseconds),
  rpi: slider("RPI", 2 * MS, 100 * MS, MS, RPI, soon, milliseconds),
  for: slider("Run for", 100 * MS, 30_000 * MS, 100 * MS, 3_000 * MS, (value) => {
    moments.last(value);
    soon();
  }),
};
seek("sliders").append(...Object.values(sliders).map((one) => one.label));

let job = null; // the selected program: title, size, m, n
let worker = null;
let number = 0; // number of the last run
let loaded = false; // true when Python has started
let running = false;
let again = false;
let dirty = false;
let page = "";

// ---- Programs

function load(chosen) {
  job = chosen;
  const robots = chosen.robots.map((text, at) => [`robot${at + 1}.toml`, text]);
  const names = Object.keys(chosen.files);
  const first = names.find((name) => /^\s*PROGRAM\b[^]*END_PROGRAM/m.test(chosen.files[name])) ?? names[0];
  editor.load({ ...chosen.files, ...Object.fromEntries(robots) }, first);
  sliders.scan.set(chosen.scan);
  sliders.rpi.set(chosen.rpi ?? RPI);
  sliders.for.set(chosen.for);
  moments.load(chosen.stimulus, chosen.for);
  dirty = false;
}

/** Return the program and the settings that the page shows. */
function current() {
  const named = Object.entries(editor.files);
  return {
    ...job,
    files: Object.fromEntries(named.filter(([name]) => !name.endsWith(".toml"))),
    robots: named.filter(([name]) => name.endsWith(".toml")).map(([, text]) => text),
    stimulus: moments.rows,
    scan: sliders.scan.value,
    rpi: sliders.rpi.value,
    for: sliders.for.value,
  };
}

async function fill() {
  const { examples, blocks } = await programs;
  const group = (label, jobs, prefix) => {
    const options = document.createElement("optgroup");
    options.label = label;
    for (const [name, { title }] of Object.entries(jobs)) options.append(new Option(title, `${prefix}=${name}`));
    return options;
  };
  seek("program").append(
    new Option("a program of your own", "own"),
    group("Examples", examples, "example"),
    group("Blocks", blocks, "block"),
  );
}

/** Load the program that the fragment of the address names or contains. */
async function open() {
  const { examples, blocks } = await programs;
  const [kind, value = ""] = location.hash.slice(1).split("=");
  let chosen = { example: examples, block: blocks }[kind]?.[value];
  let name = `${kind}=${value}`;
  if (kind === "program") {
    name = "own";
    chosen = await unpacked(value).catch(() => null);
  }
  if (!chosen) name = `example=${FIRST}`;
  load(chosen ?? examples[FIRST]);
  seek("program").value = name;
  const own = kind === "block" && chosen;
  seek("docs").hidden = !own;
  seek("docs").href = `../docs/reference/blocks/${value}.html`;
  seek("link").hidden = true;
  seek("note").hidden = Boolean(chosen) || !location.hash;
  seek("note").textContent = "The address contains no complete program, so the first example is shown.";
  clear();
  run();
}

// ---- Runs

function begin() {
  loaded = false;
  worker = new Worker("worker.js", { type: "module" });
  worker.onmessage = ({ data }) => hear(data);
  worker.onerror = (event) => hear({ failed: event.message ?? "the worker ended" });
}

/** Run the program again after a small change: now, or when the current run has ended. */
function soon() {
  if (running) again = true;
  else run();
}

function run() {
  if (!worker) begin();
  const asked = current();
  const times = Object.fromEntries(["scan", "rpi", "for"].map((key) => [key, `${asked[key]}us`]));
  [again, dirty] = [false, false];
  state(true, loaded ? "running …" : "loading Python …");
  worker.postMessage({ id: ++number, job: JSON.stringify({ ...asked, ...times, name: asked.title }) });
}

function stop(said = "stopped") {
  worker?.terminate();
  worker = null;
  state(false, said);
  begin(); // start a worker now, so the next run does not wait for Python
}

function hear(data) {
  if (data.failed) {
    state(false, "");
    worker?.terminate();
    worker = null;
    told(`the playground does not work in this browser: ${data.failed}`);
  } else if (data.loaded !== undefined || data.ready) {
    loaded = Boolean(data.ready);
    if (running) loading(data.ready ? 1 : data.loaded);
  } else if (data.trace) {
    save(data.trace, "trace.jsonl", "application/jsonl");
  } else if (data.id === number && data.share) {
    seek("progress").value = data.share;
  } else if (data.id === number && data.told) {
    state(false, "");
    show(JSON.parse(data.told));
    if (again) run();
  }
}

/** Show the downloaded share of Python and harness. */
function loading(share) {
  const percent = Math.floor(100 * share);
  let said = loaded ? "running …" : `loading Python and the harness: ${percent} %`;
  if (!loaded && share === 1) said = "starting Python …";
  seek("progress").value = loaded ? 0 : share;
  say(said);
}

function show(outcome) {
  const { error } = outcome;
  seek("wrong").hidden = !error;
  seek("result").classList.toggle("old", Boolean(error));
  editor.mark(error?.file ? error : null);
  moments.mark(error?.moment === undefined ? null : error);
  if (error) {
    const where = error.file ? `${error.file}${error.line ? `, line ${error.line}` : ""}: ` : "";
    seek("wrong").textContent = where + error.message + (error.hint ? ` (${error.hint})` : "");
    told("not run");
    return;
  }
  page = outcome.page;
  seek("chart").srcdoc = page.replace("<html ", `<html data-theme="${theme()}" `);
  seek("wait").hidden = true;
  told(outcome.told);
  seek("broken").replaceChildren(...outcome.broken.map((text) => {
    const item = document.createElement("li");
    item.textContent = text;
    return item;
  }));
  seek("trace").disabled = seek("wide").disabled = false;
}

function clear() {
  show({ page: "", told: "", broken: [] });
  seek("trace").disabled = seek("wide").disabled = true;
}

function state(isRunning, said) {
  running = isRunning;
  seek("run").disabled = isRunning;
  seek("stop").disabled = !isRunning;
  seek("progress").value = 0;
  seek("progress").classList.toggle("on", isRunning);
  say(said);
}

/** Show the state of the run; before the first chart also in the place of the chart. */
function say(said) {
  seek("state").textContent = said;
  seek("wait").textContent = said;
  seek("wait").hidden = Boolean(page) || !said;
}

const told = (text) => (seek("told").textContent = text);

function save(text, name, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), MS);
}

// ---- Hands

seek("run").onclick = run;
seek("stop").onclick = () => stop();
seek("program").onchange = ({ target }) => {
  if (target.value === "own") return;
  if (dirty && !confirm("Your changes will be lost. Continue?")) {
    target.value = location.hash.slice(1) || `example=${FIRST}`;
    return;
  }
  location.hash = target.value;
};
seek("share").onclick = async () => {
  const link = new URL(location.href);
  link.hash = `program=${await packed(current())}`;
  history.replaceState(null, "", link);
  seek("program").value = "own";
  const [field] = seek("link").getElementsByTagName("input");
  field.value = link;
  seek("link").hidden = false;
  field.select();
  const copied = await navigator.clipboard?.writeText(field.value).then(() => true, () => false);
  seek("link").querySelector("span").textContent = copied ? "is in the clipboard" : "";
};
seek("trace").onclick = () => worker?.postMessage({ id: number, trace: true });
seek("wide").onclick = () => {
  const url = URL.createObjectURL(new Blob([page], { type: "text/html" }));
  window.open(url, "_blank", "noopener");
};
onTheme((now) => seek("chart").contentWindow.postMessage({ theme: now }, "*"));
addEventListener("hashchange", open);
addEventListener("keydown", (event) => {
  if (event.key === "Enter" && (event.ctrlKey || event.metaKey) && !running) run();
});

begin();
await fill();
await open();
