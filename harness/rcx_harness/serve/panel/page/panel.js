// The faceplate of an RCX_PANEL variable. Keys are held to run: what is held is said again and
// again; when this page falls silent, rcx run releases its keys.

const EVERY_MS = 150;
const BEAT_MS = 100;
const $ = (id) => document.getElementById(id);
const all = (selector) => [...document.querySelectorAll(selector)];

const WORDS = {
  ServoOn: ["Servo on", "サーボオン"],
  Reset: ["Reset", "リセット"],
  Stop: ["Stop", "停止"],
  Start: ["Start", "起動"],
  ProgramReset: ["Program reset", "プログラムリセット"],
  StepLine: ["Step", "ステップ"],
  JogMinus: ["Jog −", "ジョグ −"],
  JogPlus: ["Jog +", "ジョグ +"],
  Teach: ["Teach", "ティーチ"],
  Operate: ["Operate", "操作"],
  Mode: ["Mode", "モード"],
  Manual: ["Manual", "手動"],
  Automatic: ["Automatic", "自動"],
  ProgramNumber: ["Program to step", "ステップするプログラム"],
  Language: ["Language", "言語"],
  Hand: ["By hand", "手動操作"],
  RobotNumber: ["Robot", "ロボット"],
  Axis: ["Axis", "軸"],
  Frame: ["Frame", "座標系"],
  Pulses: ["Pulses", "パルス"],
  Tool: ["Tool", "ツール"],
  Movement: ["Movement", "動作"],
  Held: ["While held", "押す間"],
  Steps: ["One step", "1ステップ"],
  Percent: ["Speed [%]", "速度 [%]"],
  Amount: ["Step [pulse, 0.001 mm]", "移動量 [パルス, 0.001 mm]"],
  Point: ["Point to teach", "ティーチするポイント"],
  Units: ["Unit of the point", "ポイントの単位"],
  State: ["State", "状態"],
  Position: ["Position as last read [mm, deg]", "位置（最終読出し） [mm, deg]"],
  Version: ["Library", "ライブラリ"],
  Ready: ["Ready", "準備完了"],
  NoNumber: ["There was no number in the field; the old one stays", "数値が入力されていません。前の値のままです"],
};

const LAMPS = {
  Connected: ["Connected", "接続", "green"],
  EmergencyStop: ["Emergency stop", "非常停止", "red"],
  Alarm: ["Alarm", "アラーム", "red"],
  Warning: ["Warning", "警告", "red"],
  ServoOn: ["Servos on", "サーボオン", "green"],
  AutoMode: ["AUTO at the controller", "コントローラAUTO", "green"],
  Origin: ["Origin complete", "原点復帰完了", "green"],
  Running: ["Program runs", "プログラム実行中", "green"],
  Stopped: ["Stopped", "停止中", "red"],
  Moving: ["Axis moves", "軸動作中", "green"],
  Busy: ["Busy", "処理中", "green"],
  Taught: ["Point taught", "ティーチ完了", "green"],
};

const MODES = {
  PANEL_MANUAL: ["manual", "手動"],
  PANEL_AUTOMATIC: ["automatic", "自動"],
  PANEL_AUTO_MISSING: ["automatic, but not AUTO at the controller", "自動（コントローラはAUTOではない）"],
};

// What 0 stands for: FB_Operator's usual selections.
const USUAL = { RobotNumber: 1, Axis: 1, Percent: 10, Amount: 100, ProgramNumber: 1 };
const NEXT = { PANEL_NEXT_RESET: "Reset", PANEL_NEXT_SERVO_ON: "ServoOn", PANEL_NEXT_START: "Start" };

const page = Array.from(crypto.getRandomValues(new Uint32Array(3)), (one) => one.toString(36)).join("");
const held = new Set();
const choosing = new Set(); // what was chosen and is not answered yet: promises whether it was taken
let beat = 0;
let chosen = 0;
let language = 0;
let names = [];

async function post(what, message) {
  const answer = await fetch(`api/panels/${chosen}/${what}`, {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(message),
  }).catch(() => null);
  const error = answer && !answer.ok ? (await answer.json()).error : "";
  say($("refused"), answer ? error : "no answer");
  return Boolean(answer && answer.ok);
}

function choose(name, value) {
  const answer = post("choices", { name, value });
  choosing.add(answer);
  answer.finally(() => choosing.delete(answer));
}

// Take over what is typed, and wait until the program has it: a key acts on what is shown. Not if
// it was refused, or is no number.
async function settled() {
  document.activeElement?.matches("[data-number]") && document.activeElement.blur();
  return (await Promise.all(choosing)).every(Boolean);
}

function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

const beatNow = () => post("keys", { page, beat: ++beat, keys: [...held] });

const pressing = new Set(); // keys that are down, whether the program has been told or not

async function down(button) {
  const key = button.dataset.key;
  if (pressing.has(key)) return;
  pressing.add(key);
  button.classList.add("down");
  if (key !== "Stop" && !(await settled())) {
    pressing.delete(key);
    button.classList.remove("down");
    return;
  }
  held.add(key);
  const told = beatNow();
  if (pressing.has(key)) return;
  await told; // it was let go meanwhile: a click, in its order
  held.delete(key);
  beatNow();
}

function up(button) {
  if (!pressing.delete(button.dataset.key)) return;
  button.classList.remove("down");
  if (held.delete(button.dataset.key)) beatNow();
}

function letGo() {
  for (const button of all("[data-key]")) up(button);
}

for (const button of all("[data-key]")) {
  button.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    button.setPointerCapture(event.pointerId);
    down(button);
  });
  for (const end of ["pointerup", "pointercancel", "lostpointercapture", "blur"]) {
    button.addEventListener(end, () => up(button));
  }
  button.addEventListener("keydown", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    if (!event.repeat) down(button);
  });
  button.addEventListener("keyup", () => up(button));
  button.addEventListener("contextmenu", (event) => event.preventDefault());
}
window.addEventListener("blur", letGo);
window.addEventListener("pagehide", letGo);
document.addEventListener("visibilitychange", () => document.hidden && letGo());
setInterval(() => held.size && beatNow(), BEAT_MS);

$("axes").replaceChildren(
  ...[1, 2, 3, 4, 5, 6].map((axis) => {
    const button = document.createElement("button");
    Object.assign(button.dataset, { choice: "Axis", value: axis });
    button.textContent = axis;
    return button;
  }),
);
for (const button of all("[data-choice]")) {
  button.addEventListener("click", () => {
    const value = button.dataset.value;
    choose(button.dataset.choice, /^(\d+|true|false)$/.test(value) ? JSON.parse(value) : value);
  });
}
for (const input of all("[data-number]")) {
  input.addEventListener("change", () => {
    if (input.value !== "") return choose(input.dataset.number, Number(input.value));
    input.value = input.dataset.shown ?? "";
    say($("refused"), WORDS.NoNumber[language]);
    const no = Promise.resolve(false);
    choosing.add(no);
    no.then(() => choosing.delete(no));
  });
}

$("lamps").replaceChildren(
  ...Object.keys(LAMPS).map((name) => {
    const row = document.createElement("li");
    row.dataset.lamp = name;
    row.append(document.createElement("i"), document.createElement("span"));
    return row;
  }),
);

function showTabs() {
  const tabs = $("tabs");
  if (names.length < 2) return;
  if (!tabs.children.length) {
    tabs.replaceChildren(
      ...names.map((name, place) => {
        const tab = document.createElement("button");
        tab.setAttribute("role", "tab");
        tab.textContent = name;
        tab.addEventListener("click", () => {
          letGo();
          chosen = place;
        });
        return tab;
      }),
    );
  }
  [...tabs.children].forEach((tab, place) => tab.setAttribute("aria-selected", String(place === chosen)));
}

function show(now) {
  language = Number(now.Language === "LANGUAGE_JAPANESE");
  document.title = `${now.name}: RCX3 panel`;
  for (const one of all("[data-word]")) say(one, WORDS[one.dataset.word][language]);
  for (const button of all("[data-key]")) {
    const key = button.dataset.key;
    say(button, WORDS[key][language]);
    button.classList.toggle("cannot", !now.Can[key]);
    button.classList.toggle("next", NEXT[now.Following] === key);
    button.setAttribute("aria-pressed", String(now.Key[key]));
  }
  for (const button of all("[data-choice]")) {
    const name = button.dataset.choice;
    const value = now[name] || (USUAL[name] ?? now[name]);
    button.setAttribute("aria-pressed", String(String(value) === button.dataset.value));
  }
  for (const input of all("[data-number]")) {
    const name = input.dataset.number;
    input.dataset.shown = now[name] || (USUAL[name] ?? now[name]);
    if (document.activeElement !== input) input.value = input.dataset.shown;
  }
  for (const row of $("lamps").children) {
    const [english, japanese, colour] = LAMPS[row.dataset.lamp];
    const on = now.Lamp[row.dataset.lamp];
    row.classList.toggle("on", on);
    row.firstChild.className = on ? `led ${colour}` : "led";
    say(row.lastChild, [english, japanese][language]);
  }
  say($("mode"), MODES[now.Mode][language]);
  const message = now.Message;
  const card = $("message");
  card.className = `card ${now.Lamp.Fault ? "fault" : now.MessageID ? "hint" : ""}`;
  say(card.querySelector("b"), message.Name || WORDS.Ready[language]);
  const alarm = now.AlarmGroup ? `, ${now.AlarmGroup}.${now.AlarmCategory}` : "";
  const number = now.MessageID.toString(16).toUpperCase().padStart(4, "0");
  say(card.querySelector("code"), now.MessageID ? `16#${number}${alarm}` : "");
  const join = (first, second) => [first, second].filter(Boolean).join(language ? "" : " ");
  say(card.querySelector(".cause"), join(message.Cause1, message.Cause2));
  say(card.querySelector(".remedy"), join(message.Remedy1, message.Remedy2));
  const rows = $("position");
  if (!rows.children.length) {
    rows.replaceChildren(
      ...now.Position.map((_, place) => {
        const row = document.createElement("div");
        row.append(document.createElement("dt"), document.createElement("dd"));
        row.firstChild.textContent = place + 1;
        return row;
      }),
    );
  }
  say($("version"), [1e4, 1e2, 1].map((one) => Math.floor(now.Version / one) % 100).join("."));
  now.Position.forEach((value, place) => say(rows.children[place].lastChild, value.toFixed(3)));
}

async function get(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(answer.statusText);
  return answer.json();
}

async function live() {
  if (!document.hidden) {
    try {
      if (!names.length) names = await get("api/panels");
      const asked = chosen;
      const now = await get(`api/panels/${asked}`);
      showTabs();
      if (asked === chosen && now.Key) show(now);
      $("lost").hidden = true;
    } catch {
      $("lost").hidden = false;
    }
    document.body.classList.toggle("stale", !$("lost").hidden);
  }
  setTimeout(live, EVERY_MS);
}

live();
