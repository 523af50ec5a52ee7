// The parts of the page that need no browser. Expected values: by hand, from what the heads of the
// functions say. test_pure.py puts the scripts of the page beside this file.

import assert from "node:assert/strict";
import { test } from "node:test";
import { Axis, duration, neighbour, seconds, snapped, ticks } from "./axis.js";
import { Events, Lane, countUntil, reader, speed } from "./data.js";
import { pieces } from "./draw.js";
import { commentAt, placeText } from "./listing.js";
import { bitOf, statesOf } from "./networks.js";
import { Player, reached } from "./play.js";
import { nextTime, placesAt } from "./programs.js";
import { figure, jointsOf } from "./robot.js";
import { lastTimes, poseAt } from "./robots.js";
import { find, matcher, step, wordsOf } from "./search.js";

const bytes = (...numbers) => Uint8Array.from(numbers);

// A lane of bits with changes at 10, 20, 30 ... of which the first is to ON.
function wave(count, more = {}) {
  const entry = { name: "SI(00) Emergency stop input", short: "SI(00)", form: "bit", colour: "input", first: 0 };
  return new Lane({ ...entry, count, at: [0, count], ...more }, 0, new Uint8Array(count).fill(10), [], [], 5000);
}

// A lane of numbers.
function curve(times, values, more = {}) {
  const lane = new Lane({ name: "X", form: "whole", colour: "curve", first: 0, count: 0, at: [0, 0], ...more }, 0, bytes(), [], [], 5000);
  Object.defineProperty(lane, "times", { value: Float64Array.from(times) });
  Object.defineProperty(lane, "values", { value: Float64Array.from(values) });
  return lane;
}

test("numbers are read as pack.py writes them", () => {
  const { whole } = reader(bytes(0, 0x7f, 0x80, 1, 0x90, 0x4e, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x80, 0x10));
  assert.deepEqual([whole(), whole(), whole(), whole(), whole()], [0, 127, 128, 10000, 2 ** 53]);
  const { signed } = reader(bytes(0, 1, 2, 3));
  assert.deepEqual([signed(), signed(), signed(), signed()], [0, -1, 1, -2]);
  const { real } = reader(Uint8Array.from([9, ...new Uint8Array(Float64Array.of(-0.5).buffer)]), 1);
  assert.equal(real(), -0.5);
});

test("a lane has its first value until its first change", () => {
  const lane = wave(3);
  assert.deepEqual([...lane.times], [10, 20, 30]);
  const at = (t) => lane.value(lane.indexAt(t));
  assert.deepEqual([9, 10, 19.9, 20, 30, 99].map(at), [0, 1, 1, 0, 1, 1]);
  assert.equal(lane.told(0), "SI(00) ON   Emergency stop input");
});

test("numbers, texts and positions come back as they were", () => {
  const make = (entry, ...given) => new Lane({ name: "X", first: 0, at: [0], ...entry }, 0, bytes(...given), [], ["a", "b"], 5000);
  assert.deepEqual([...make({ form: "whole", count: 2, first: 7 }, 1, 1, 1, 4).values], [6, 8]);
  const fine = make({ form: "whole", count: 1, first: 500, fine: 1000 }, 1, 2);
  assert.deepEqual([fine.value(-1), fine.value(0)], [0.5, 0.501]);
  const text = make({ form: "text", count: 1, first: 0 }, 5, 1);
  assert.deepEqual([text.text(text.value(-1)), text.text(text.value(0))], ["a", "b"]);
  assert.equal(make({ form: "whole", digits: 4 }).text(0x1f), "16#001F");
  assert.equal(make({ form: "real", precision: 7 }).text(0.10000000149), "0.1");
});

test("the least and the greatest of any part are those of all its values", () => {
  const values = Array.from({ length: 9000 }, (_, k) => (k * 7919) % 10007);
  const lane = curve(values.map((_, k) => k), values);
  for (const [begin, end] of [[0, 1], [0, 9000], [63, 65], [64, 128], [1, 8999], [4095, 8193], [130, 131]]) {
    const part = values.slice(begin, end);
    assert.deepEqual(lane.span(begin, end), [Math.min(...part), Math.max(...part)], `${begin} to ${end}`);
  }
});

test("a speed is the way within a cycle, and 0 where nothing moves", () => {
  const { times, values } = speed(curve([20000, 25000, 50000], [1, 3, 2]));
  assert.deepEqual([...times], [15000, 20000, 25000, 45000, 50000]);
  assert.deepEqual([...values], [200, 400, 0, -200, 0]); // 1 in 5 ms is 200 in a second
});

test("the axis keeps the time under the pointer while it zooms, and stays where there is something", () => {
  const axis = new Axis(0, 1000);
  axis.width = 100;
  assert.deepEqual([axis.x(250), axis.t(50)], [25, 500]);
  axis.zoom(0.5, 20);
  assert.deepEqual([axis.from, axis.to, axis.t(20)], [100, 600, 200]);
  axis.pan(-500);
  assert.deepEqual([axis.from, axis.to], [0, 500]);
  axis.zoom(100);
  assert.deepEqual([axis.from, axis.to], [0, 1000]);
  axis.show(400, 401);
  assert.equal(axis.span, 50); // it shows no less
  axis.show(400, 600);
  axis.zoom(1e-9, 20);
  assert.deepEqual([axis.span, Math.round(axis.t(20))], [50, 440]);
  axis.reveal(900);
  assert.deepEqual([axis.from, axis.to], [875, 925]);
});

test("room at both ends is part of the axis", () => {
  const axis = new Axis(0, 1000, 0.01);
  assert.deepEqual([axis.from, axis.to], [-10, 1010]);
});

test("marks are at round times and not nearer than was asked for", () => {
  const axis = new Axis(0, 1_000_000);
  axis.width = 1000;
  const marks = ticks(axis, 90);
  assert.equal(marks.step, 100_000);
  assert.deepEqual(marks.times.slice(0, 3), [0, 100_000, 200_000]);
});

test("times are told as exactly as is needed", () => {
  assert.equal(seconds(1_500_000, 100_000), "1.5 s");
  assert.equal(seconds(1_500_000, 1000), "1.500 s");
  assert.equal(seconds(12, 1), "0.000012 s");
  assert.equal(seconds(4_000_000, 2_000_000), "4 s");
  assert.deepEqual([-950, 100_000, -2_500_000].map(duration), ["-950 µs", "100 ms", "-2.5 s"]);
});

test("a cursor goes to the change that is near, and from change to change", () => {
  const lane = wave(3);
  assert.deepEqual([snapped([lane], 12.4, 4), snapped([lane], 17, 4), snapped([lane], 15, 4)], [10, 20, 15]);
  assert.deepEqual([neighbour(lane, 10, 1), neighbour(lane, 10, -1), neighbour(lane, 15, -1)], [20, undefined, 10]);
  assert.equal(neighbour(lane, 30, 1), undefined);
});

test("a lane is drawn in pieces: what is within a pixel is one", () => {
  const axis = new Axis(0, 100);
  axis.width = 100;
  const few = [...pieces(wave(3), axis)].map(({ x, end, index, many }) => [x, end, index, many]);
  assert.deepEqual(few, [[0, 10, -1, false], [10, 20, 0, false], [20, 30, 1, false], [30, 100, 2, false]]);
  axis.show(0, 100);
  axis.width = 5; // 20 to the pixel, two changes each
  for (const piece of pieces(wave(9), axis)) assert.ok(piece.end > piece.x);
  const drawn = [...pieces(wave(9), axis)];
  assert.ok(drawn.some((piece) => piece.many));
  assert.ok(drawn.length <= 5);
  assert.equal(drawn.at(-1).index, 8);
  axis.begin = 0;
  [axis.end, axis.width] = [1000, 10];
  axis.fit();
  const burst = [...pieces(wave(9, { at: [0, 9] }), axis)].map(({ end, index, many }) => [end, index, many]);
  assert.deepEqual(burst.at(-1), [10, 8, false], "what comes behind many changes is one piece");
});

test("a search says it as people do", () => {
  assert.deepEqual(wordsOf("next SO(13) edge"), ["so(13)"]);
  assert.deepEqual(wordsOf("SO13 off"), ["so(13)", "off"]);
  const on = matcher("si00 on");
  assert.ok(on("SI(00) ON   Emergency stop input"));
  assert.ok(!on("SI(00) OFF  Servo ON input"), "of on and off only the level counts");
  assert.ok(matcher("move on")("Main.Move.Busy := TRUE"));
  assert.ok(!matcher("true")("Main.Move.Busy := FALSE"));
});

test("events are found, one after the other, and again from the beginning", () => {
  const lanes = [wave(3), wave(2, { name: "SO(13) Program", short: "SO(13)" })];
  lanes.forEach((lane, k) => (lane.number = k));
  const events = new Events(lanes, bytes(0, 1, 0, 1, 0), { at: 0, count: 5 });
  assert.deepEqual([0, 1, 2, 3, 4].map((k) => events.time(k)), [10, 10, 20, 20, 30]);
  const found = find(events, "next SO(13) edge");
  assert.deepEqual([...found], [1, 3]);
  assert.deepEqual([...find(events, "so(13) off")], [3]);
  assert.deepEqual([...find(events, "", (lane) => lane === lanes[1])], [1, 3]);
  assert.deepEqual([step(events, found, -1, 1), step(events, found, 10, 1), step(events, found, 20, 1)], [0, 1, 0]);
  assert.deepEqual([step(events, found, 20, -1), step(events, found, 10, -1), step(events, [], 0, 1)], [0, 1, -1]);
});

test("a count of sorted times", () => {
  assert.deepEqual([0, 1, 2, 5, 9].map((t) => countUntil([1, 2, 2, 5], t)), [0, 1, 3, 4, 4]);
});

// Arms of 225 and 175 mm: at 0 degrees stretched to the front, along Y, and R is 90 degrees.
const axes = [{ per: 10, zero: 5 }, { per: 10, zero: 0 }, { per: 10, zero: 0 }, { per: 10, zero: 0 }];
const scara = { kind: "scara", arms: [225, 175], axes };
const near = (found, expected) =>
  found.forEach((value, k) => assert.ok(Math.abs(value - expected[k]) < 1e-9, `${found} is not ${expected}`));

test("arms stand where their joints are", () => {
  near(figure(scara, [0, 0, 50, 0]).tool, [0, 400, 50]);
  near(figure(scara, [90, 0, 0, 0]).tool, [-400, 0, 0]);
  const bent = figure(scara, [0, 90, 0, 10]);
  near([...bent.elbow, ...bent.flange, bent.r], [0, 225, -175, 225, 0, 190]);
  near(figure({ kind: "cartesian", axes }, [1, 2, 3, 4]).tool, [1, 2, 3]);
});

test("a hand on the R axis turns with it, one beside it is another arm", () => {
  near(figure(scara, [0, 0, 0, -90], { hand: [10, 0, 5, 1] }).tool, [10, 400, 5]);
  near(figure(scara, [0, 0, 0, 0], { hand: [10, 0, 5, 1] }).tool, [0, 410, 5]);
  const beside = figure(scara, [0, 0, 0, 0], { hand: [90, 25, 5, 0] });
  near([...beside.tool, beside.r], [-200, 225, 5, 90]);
});

test("joints are found from pulses, and from the tool's place in shifted coordinates", () => {
  near(jointsOf(scara, [905, 100, 20, -10], "pulses"), [90, 10, 2, -1]);
  near(jointsOf(scara, [-175, 225, 7, 180], "mm"), [0, 90, 7, 0]);
  near(jointsOf(scara, [175, 225, 7, 0], "mm", { left: true }), [0, -90, 7, 0]);
  near(jointsOf(scara, [0, 275, 0, 90], "mm", { shift: [100, 225, 0, 90] }), [0, 90, 0, 0]);
  assert.equal(jointsOf(scara, [401, 0, 0, 0], "mm"), null);
  near(jointsOf({ kind: "axes", axes }, [1, 2, 3, 4], "mm"), [1, 2, 3, 4]);
});

test("axis 2 comes within half a turn however far the hand beside the R axis is turned", () => {
  for (const [axis2, turned] of [[110, 80], [-110, -80], [150, 180], [-150, -180], [150, 350]]) {
    const line = ((axis2 + turned) * Math.PI) / 180;
    const [x, y, left] = [-175 * Math.sin(line), 225 + 175 * Math.cos(line), Math.sin(line) < 0];
    const found = jointsOf(scara, [x, y, 7, axis2 + 90], "mm", { left, hand: [turned, 0, 0, 0] });
    near(found, [0, axis2, 7, 0]);
  }
  near(jointsOf(scara, [0, 50, 0, 270], "mm"), [0, 180, 0, 0]);
});

test("a pose holds from its time on, and the last changes of all lanes count once", () => {
  const poses = [[10, { left: true }], [20, {}]];
  assert.deepEqual([9, 10, 19, 20].map((t) => poseAt(poses, t)), [{}, { left: true }, { left: true }, {}]);
  const lanes = [curve([10, 20, 30], [1, 2, 3]), curve([20, 25], [1, 2])];
  assert.deepEqual(lastTimes(lanes, 25, 10), [10, 20, 25]);
  assert.deepEqual(lastTimes(lanes, 30, 2), [25, 30]);
});

test("a played time follows the clock and its pace, up to the end", () => {
  assert.deepEqual([0, 100, 1000].map((ms) => reached(5_000, ms, 1, 300_000)), [5_000, 105_000, 300_000]);
  assert.equal(reached(0, 1000, 0.25, 1e9), 250_000);
});

test("playing ends at the end, or when it is stopped, and can be started again", () => {
  const [frames, times, states] = [[], [], []];
  const player = new Player((one) => frames.push(one), (t) => times.push(t), () => states.push(player.playing));
  const tick = (now) => frames.splice(0).forEach((one) => one(now));
  player.start(0, 200_000, 1);
  for (const now of [7, 57, 107]) tick(now);
  player.stop();
  tick(157); // the frame that was asked for before
  assert.deepEqual(times, [0, 50_000, 100_000]);
  player.start(100_000, 200_000, 2);
  for (const now of [1000, 1025, 1100]) tick(now);
  assert.deepEqual(times.slice(3), [100_000, 150_000, 200_000]);
  assert.deepEqual([states, frames.length], [[true, false, true, false], 0]);
});

test("a comment begins at an apostrophe that is in no text, or with REM", () => {
  assert.equal(commentAt("MOVE P,P1 ' to the part"), 10);
  assert.equal(commentAt('PRINT "it\'s" \' end'), 13);
  assert.equal(commentAt("HALT"), 4);
  assert.equal(commentAt("  rem all"), 0);
  assert.equal(commentAt("REMOTE%=1"), 9);
});

test("a task is told with its line unless it is in none", () => {
  assert.equal(placeText({ task: 2, line: 4, state: "running" }), "task 2, line 4, running");
  assert.equal(placeText({ task: 1, line: 1, state: "ready" }), "task 1, ready");
  assert.equal(placeText(null), "in no task");
});

test("a program is where its task is at a time, and a click leads to the next time in a line", () => {
  const lane = curve([10, 20, 25, 30, 40], [1, 2, 4, 1, 3]);
  const texts = {
    0: ["PLACE", 1, "ready"],
    1: ["PLACE", 4, "running"],
    2: ["PLACE", 7, "running"],
    4: ["PLACE", 7, "stopped"],
  };
  const entry = { tasks: [[1, lane]], texts };
  const at = (t) => placesAt(entry, t).get("PLACE");
  assert.deepEqual(at(5), { task: 1, line: 1, state: "ready" });
  assert.deepEqual(at(20), { task: 1, line: 7, state: "running" });
  assert.equal(at(40), undefined); // it has left the table of tasks
  const next = (line, t) => nextTime(entry, "PLACE", line, t)?.t;
  assert.deepEqual([next(4, 0), next(4, 10), next(4, 30), next(9, 0)], [10, 30, 10, undefined]);
  assert.equal(next(7, 20), 20); // at 25 it is stopped there
});

const from = (...ends) => [{ pin: "", from: ends.map((end) => end.split(".").concat("").slice(0, 2)), always: null, negated: false, edge: false }];
const tests = (id, path, source, negated = false) => ({ id, kind: "contact", in: from(source), name: path, tests: path, negated });

test("the power of a rung flows through contacts, and what is not known is not off", () => {
  const rung = [tests("1", "A", ""), tests("2", "B", "1", true), { id: "3", kind: "coil", in: from("2"), name: "Q", stores: false, negated: false }];
  const at = (values) => {
    const { power, symbol, name } = statesOf(rung, (path) => values[path]);
    return [power("1"), power("2"), symbol("2"), symbol("3"), power("3"), name("3")];
  };
  assert.deepEqual(at({ A: true, B: false, Q: true }), [true, true, true, true, true, true]);
  assert.deepEqual(at({ A: true, B: true, Q: false }), [true, false, false, false, false, false]);
  assert.deepEqual(at({ A: false, Q: false }), [false, false, null, false, false, false]);
  assert.deepEqual(at({ A: true }), [true, null, null, null, null, null]);
  // Of a coil that assigns, the variable says what its power was; of one that sets, it does not.
  assert.equal(at({ A: true, Q: true })[3], true);
  rung[2].stores = true;
  assert.equal(at({ A: true, Q: true })[3], null);
});

test("parallel lines are joined by OR, and a closed line hides one that is not known", () => {
  const both = [tests("1", "A", ""), tests("2", "B", ""), { id: "3", kind: "coil", in: from("1", "2"), name: null, stores: true }];
  const coil = (values) => statesOf(both, (path) => values[path]).symbol("3");
  assert.deepEqual([{ A: true }, { A: false }, { A: false, B: false }].map(coil), [true, null, false]);
  // Behind such a coil, tools differ; but not at the right rail.
  assert.equal(statesOf(both, () => true).power("3"), true);
  both.push(tests("4", "C", "3"));
  assert.equal(statesOf(both, () => true).power("3"), null);
});

test("a block has the values of its outputs; operators are calculated", () => {
  const pins = (...ends) => ends.map((end, k) => ({ ...from(end)[0], pin: `IN${k + 1}` }));
  const out = [{ pin: "OUT", name: null, negated: false, number: false }];
  const reads = ["A", "B"].map((path, k) => ({ id: String(k + 1), kind: "read", in: [], name: path, always: null, negated: false, number: false }));
  const made = (type, values) => statesOf([...reads, { id: "9", kind: "block", type, in: pins("1", "2"), out }], (path) => values[path]).power("9", "OUT");
  assert.deepEqual(["AND", "OR", "XOR", "GT"].map((type) => made(type, { A: true, B: false })), [false, true, true, null]);
  assert.deepEqual(["AND", "OR", "XOR"].map((type) => made(type, { A: true })), [null, true, null]);
  const timer = { id: "9", kind: "block", type: "", in: [], out: [
    { pin: "Q", name: "T.Q", negated: true, number: false },
    { pin: "ET", name: "T.ET", negated: false, number: true },
  ] };
  const { power, path } = statesOf([timer], (name) => ({ "T.Q": false, "T.ET": "T#5ms" })[name]);
  assert.deepEqual([power("9", "Q"), power("9", "ET"), path("9", "ET")], [true, undefined, "T.ET"]);
});

test("integers are compared, if the comparison is executed", () => {
  const pins = (...ends) => ends.map(([pin, end]) => ({ ...from(end)[0], pin, constant: null }));
  const reads = [tests("0", "Go", ""), { id: "1", kind: "read", in: [], name: "N", always: null, constant: null, number: true }, { id: "2", kind: "read", in: [], name: null, always: null, constant: 7, number: true }];
  const out = [{ pin: "OUT", name: null, negated: false, number: false }];
  const made = (type, values) => statesOf([...reads, { id: "9", kind: "block", type, in: pins(["EN", "0"], ["IN1", "1"], ["IN2", "2"]), out }], (path) => values[path]).power("9", "OUT");
  const all = (N) => ["GT", "GE", "EQ", "LE", "LT", "NE"].map((type) => made(type, { Go: true, N }));
  assert.deepEqual(all(6), [false, false, false, true, true, true]);
  assert.deepEqual(all(7), [false, true, true, true, false, false]);
  assert.deepEqual([made("GT", { Go: false, N: 8 }), made("GT", { Go: true }), made("GT", { Go: true, N: "T#8s" })], [null, null, null]);
  // A contact that compares, as an instruction of Logix does.
  const tested = { ...tests("1", null, ""), compare: ["LE", { name: "N", constant: null }, { name: null, constant: 7 }] };
  assert.deepEqual([7, 8, "x"].map((n) => statesOf([tested], () => n).power("1")), [true, false, null]);
  // An integer at the pin itself, and three inputs.
  const three = [...pins(["IN1", "1"], ["IN2", "2"]), { pin: "IN3", from: [], always: null, constant: 9, negated: false, edge: false }];
  const block = { id: "9", kind: "block", type: "LT", in: three, out };
  assert.deepEqual([6, 7].map((n) => statesOf([...reads, block], () => n).power("9", "OUT")), [true, false]);
});

test("a bit of an integer is known", () => {
  assert.deepEqual([0, 1, 2, 3, 31].map((bit) => bitOf(10, bit)), [false, true, false, true, false]);
  // -2 is 16#FFFE in 16 bits.
  assert.deepEqual([0, 1, 15].map((bit) => bitOf(-2, bit)), [false, true, true]);
  assert.equal(bitOf("T#1s", 0), undefined);
});

test("ENO has the power of EN, and an edge at a pin and a loop are not known", () => {
  const enabled = { id: "2", kind: "block", type: "MOVE", in: [{ ...from("1")[0], pin: "EN" }], out: [{ pin: "ENO", name: null, negated: false, number: false }] };
  const both = [tests("1", "A", ""), enabled];
  assert.equal(statesOf(both, () => true).power("2", "ENO"), true);
  assert.equal(statesOf(both, () => false).power("2", "ENO"), false);
  enabled.in[0].edge = true;
  assert.equal(statesOf(both, () => true).power("2", "ENO"), null);
  const loop = [{ id: "1", kind: "connector", line: "X", in: from("2") }, { id: "2", kind: "continuation", line: "X", in: [] }];
  assert.equal(statesOf(loop, () => true).power("2"), null);
});
