// Draws lanes onto a canvas: only what is seen, and no more than a piece for each pixel.

import { countUntil } from "./data.js";

const EDGE = 3; // pixels that a box of a text is pointed by
const LETTER = 6.7; // width of a letter in such a box
const DENSE = 1; // changes within a pixel are one block of colour
const THIN = 0.75; // half a line

// The pieces of a lane from left to right: from x to x, the number of the change that holds there;
// `many` where several changes are within one pixel.
export function* pieces(lane, axis) {
  const { times } = lane;
  let index = lane.indexAt(axis.from);
  let x = 0;
  while (x < axis.width) {
    const next = index + 1 < times.length ? axis.x(times[index + 1]) : Infinity;
    if (next >= x + DENSE || next >= axis.width) {
      yield { x, end: Math.min(next, axis.width), index, many: false };
      x = next;
      index += 1;
    } else {
      const end = Math.floor(x) + 1 + DENSE;
      const last = countUntil(times, axis.t(end)) - 1;
      yield { x, end: Math.min(end, axis.width), index: last, many: last > index };
      x = end;
      index = last;
    }
  }
}

// Draws a lane between `top` and `top + height`.
export function drawLane(context, lane, axis, top, height, colours) {
  const colour = colours[lane.colour];
  context.strokeStyle = context.fillStyle = colour;
  context.lineWidth = 1.5;
  if (lane.colour === "rule") drawMarks(context, lane, axis, top, height);
  else if (lane.curve) drawCurve(context, lane, axis, top, height, colours);
  else if (lane.form === "bit") drawWave(context, lane, axis, top, height, colours);
  else drawBoxes(context, lane, axis, top, height, colours);
}

// The places of a lane's changes, one for those that nobody could tell apart.
function* marks(lane, axis, apart) {
  let last = -Infinity;
  for (let k = lane.indexAt(axis.t(-6)) + 1; k < lane.times.length; ) {
    const x = axis.x(lane.times[k]);
    if (x > axis.width + 6) return;
    if (x - last >= apart) yield (last = x);
    k = Math.max(k + 1, countUntil(lane.times, axis.t(last + apart)));
  }
}

function drawMarks(context, lane, axis, top, height) {
  for (const x of marks(lane, axis, 2)) {
    context.beginPath();
    context.moveTo(x - 6, top + height - 4);
    context.lineTo(x + 6, top + height - 4);
    context.lineTo(x, top + 5);
    context.fill();
  }
}

// Where rules were broken, a line through all rows.
export function drawRules(context, lane, axis, height, colours) {
  context.fillStyle = colours.rule;
  context.globalAlpha = 0.35;
  for (const x of marks(lane, axis, 3)) context.fillRect(Math.round(x), 0, 1, height);
  context.globalAlpha = 1;
}

function drawWave(context, lane, axis, top, height, colours) {
  const high = top + 5;
  const low = top + height - 5;
  const line = new Path2D();
  let level = null;
  for (const { x, end, index, many } of pieces(lane, axis)) {
    const on = lane.value(index) > 0;
    const y = on ? high : low;
    if (many) {
      context.globalAlpha = 0.55;
      context.fillRect(x, high, end - x, low - high);
      level = null;
      continue;
    }
    if (on) {
      context.globalAlpha = colours.fill;
      context.fillRect(x, high, end - x, low - high);
    }
    if (level === null) line.moveTo(x, y);
    else line.lineTo(x, level);
    line.lineTo(x, y);
    line.lineTo(end, y);
    level = y;
  }
  context.globalAlpha = 1;
  context.stroke(line);
}

function drawBoxes(context, lane, axis, top, height, colours) {
  const high = top + 4;
  const low = top + height - 4;
  const middle = (high + low) / 2;
  for (const { x, end, index, many } of pieces(lane, axis)) {
    const value = lane.value(index);
    context.strokeStyle = context.fillStyle = colours[lane.colour];
    if (many) {
      context.globalAlpha = 0.55;
      context.fillRect(x, high, end - x, low - high);
      context.globalAlpha = 1;
      continue;
    }
    context.beginPath();
    if (value === lane.idle || (lane.digits && !value)) {
      context.moveTo(x, middle);
      context.lineTo(end, middle);
      context.stroke();
      continue;
    }
    const edge = Math.min(EDGE, (end - x) / 2);
    context.moveTo(x, middle);
    context.lineTo(x + edge, high);
    context.lineTo(end - edge, high);
    context.lineTo(end, middle);
    context.lineTo(end - edge, low);
    context.lineTo(x + edge, low);
    context.closePath();
    context.globalAlpha = colours.fill;
    context.fill();
    context.globalAlpha = 1;
    context.stroke();
    label(context, lane.text(value), x + 6, end - 4, low - 5, colours.ink);
  }
}

// As much of a text as there is room for; nothing where nobody would understand it.
function label(context, text, x, end, y, colour) {
  const letters = Math.floor((end - x) / LETTER);
  if (letters < Math.min(text.length, 4)) return;
  context.fillStyle = colour;
  context.fillText(text.length > letters ? `${text.slice(0, letters - 1)}…` : text, x, y);
}

function drawCurve(context, lane, axis, top, height, colours) {
  const [least, greatest] = lane.limits;
  const low = top + height - 6;
  const room = height - 12;
  const scale = greatest > least ? room / (greatest - least) : 0;
  const y = (value) => low - (scale ? (value - least) * scale : room / 2);
  if (least < 0 && greatest > 0) {
    context.fillStyle = colours.line;
    context.fillRect(0, y(0), axis.width, 1);
  }
  context.fillStyle = colours[lane.colour];
  const line = new Path2D();
  let first = lane.indexAt(axis.from) + 1; // of the changes that are not drawn yet
  let before = y(lane.value(first - 1));
  line.moveTo(0, before);
  for (const { x, end, index, many } of pieces(lane, axis)) {
    const after = y(lane.value(index));
    if (many) {
      const [low, high] = lane.span(first, index + 1).map(y);
      const [over, under] = [Math.min(high, before), Math.max(low, before)];
      line.lineTo(x, before);
      line.moveTo(end, after);
      context.fillRect(x, over - THIN, end - x, under - over + 2 * THIN);
    } else {
      if (x > 0 && index >= first) {
        const arrived = lane.times[index];
        const left = lane.rests ? Math.max(arrived - lane.cycle, lane.times[index - 1] ?? 0) : arrived;
        line.lineTo(axis.x(left), before); // until then it stood still
      }
      line.lineTo(x, after);
      if (end >= axis.width) line.lineTo(end, after);
    }
    before = after;
    first = index + 1;
  }
  context.strokeStyle = colours[lane.colour];
  context.stroke(line);
  if (!scale) return;
  context.fillStyle = colours.soft;
  context.fillText(lane.text(greatest), 4, top + 12);
  context.fillText(lane.text(least), 4, top + height - 3);
}

// The marks of the time axis, and its rules over all lanes.
export function drawTimes(context, marks, axis, height, colours, text) {
  context.fillStyle = colours.soft;
  context.textAlign = "center";
  for (const t of marks.times) {
    const x = axis.x(t);
    const said = text(t, marks.step);
    const half = (said.length * LETTER) / 2;
    context.fillRect(x, height - 5, 1, 5);
    context.fillText(said, Math.min(Math.max(x, half), axis.width - half), height - 9);
  }
  context.textAlign = "left";
}
