// The page of `rcx serve`: asks for the state a few times a second and shows it.

import { Chart } from "./chart.js";
import { Monitor, element, say } from "./monitor.js";
import { Operate } from "./operate.js";
import { Positions } from "./positions.js";
import { Programs } from "./programs.js";

const EVERY_MS = 200;
const $ = (id) => document.getElementById(id);

const monitor = new Monitor($("monitor"));
const chart = new Chart($("chart"), $("measure"));
const positions = new Positions($("robots"), $("positions").tBodies[0]);
const programs = new Programs($("programs"), $("listings"));
let chosen = 0;
const operate = new Operate(() => chosen);

async function get(path) {
  const answer = await fetch(path);
  if (!answer.ok) throw new Error(answer.statusText);
  return answer;
}

function notes(list, entries, render) {
  const key = JSON.stringify(entries);
  if (list.dataset.key === key) return;
  list.dataset.key = key;
  list.replaceChildren(...entries.map(render));
}

function lamp(state) {
  return `led ${state.replace(/,? /g, "-")}`;
}

function showTabs(robots) {
  const tabs = $("tabs");
  if (tabs.children.length !== robots.length) {
    tabs.replaceChildren(
      ...robots.map((one) => {
        const tab = element("button", { role: "tab" }, element("i"), element("i"), element("span"));
        tab.addEventListener("click", () => choose(one.id));
        return tab;
      }),
    );
  }
  robots.forEach((one, place) => {
    const tab = tabs.children[place];
    const [module, network, name] = tab.children;
    module.className = lamp(one.leds[0].state);
    network.className = lamp(one.leds[1].state);
    say(name, one.running ? one.name : `${one.name} (ended)`);
    tab.setAttribute("aria-selected", String(one.id === chosen));
    tab.classList.toggle("alarm", one.alarms.length > 0);
  });
}

function choose(id) {
  chosen = id;
  operate.forget();
  update();
}

function showState(one) {
  notes($("leds"), one.leds, (led) =>
    element(
      "li",
      {},
      element("i", { class: lamp(led.state) }),
      element("b", {}, led.title),
      element("span", {}, `${led.state}: ${led.meaning}`),
    ),
  );
  say($("connection"), one.connection);
  $("connection").classList.toggle("up", one.connected);
  const packets = one.packets;
  const figures = [
    ["Area", `${one.size} bytes`],
    ["Packets in / out", `${packets.received} / ${packets.sent}`],
    ...(packets.dropped ? [["Packets dropped", packets.dropped]] : []),
    ["Controller cycles", `${one.cycles} of 5 ms`],
    ["Cycles skipped", String(one.skipped)],
  ];
  notes($("figures"), figures, ([name, value]) =>
    element("div", {}, element("dt", {}, name), element("dd", {}, value)),
  );
}

function showNotes(one) {
  say($("executed"), one.executed ? `${one.executed} ended` : "");
  notes($("command-list"), one.commands, (command) =>
    element(
      "li",
      {},
      element("time", {}, command.time),
      element("span", {}, command.request),
      element("em", { class: /^abnormal/.test(command.result) ? "bad" : "" },
        command.result || "running ..."),
    ),
  );
  notes($("alarms"), one.alarms, (text) => element("li", { class: "bad" }, text));
  say($("violation-count"), one.violation_count ? String(one.violation_count) : "");
  notes($("violations"), one.violations, (note) =>
    element("li", {}, element("time", {}, note.time), element("span", {}, note.text)),
  );
}

async function update() {
  const asked = chosen;
  const [robots, now] = await Promise.all([
    get("api/robots").then((answer) => answer.json()),
    get(`api/robots/${asked}`).then((answer) => answer.json()),
  ]);
  if (asked !== chosen) return;
  document.title = `${now.name}: RCX3 virtual controller`;
  showTabs(robots);
  showState(now);
  operate.show(now);
  if (positions.wants(now)) {
    const model = await (await get(`api/robots/${asked}/model`)).json();
    if (asked !== chosen) return;
    positions.model(now, model);
  }
  positions.show(now);
  if (programs.wants(now)) {
    const listings = await (await get(`api/robots/${asked}/programs`)).json();
    if (asked !== chosen) return;
    programs.list(now, listings);
  }
  programs.show(now);
  showNotes(now);
  monitor.show(now);
  if (chart.wants(asked)) {
    const answer = await get(`api/robots/${asked}/chart.svg?seconds=${chart.seconds}&width=${chart.width}`);
    const svg = await answer.text();
    if (asked === chosen) chart.show(asked, svg);
  }
}

async function live() {
  if (!document.hidden) {
    try {
      await update();
      $("lost").hidden = true;
    } catch {
      $("lost").hidden = false;
    }
    document.body.classList.toggle("stale", !$("lost").hidden);
  }
  setTimeout(live, EVERY_MS);
}

chart.tools($("windows"), $("pause"));
live();
