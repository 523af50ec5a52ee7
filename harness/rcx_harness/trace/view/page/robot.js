// A robot from above and from the side, to scale: arms, limits, tool, the way that it has gone,
// points, pallets and work areas by their names; below it each axis between its soft limits. Of a
// robot whose type is not known only the axes are drawn.
//
// Takes nothing from elsewhere. The page gives what rcx_harness/robot/shape.py says as JSON:
//
//   const view = new RobotView(host, model, { unit: "pulses" });   // or "mm": of the positions;
//                                   // high: 250 is the greatest height of one of both views [px]
//   view.show(positions, pose, trail);     // again and again; positions null: not known
//   trail.push(view.place(positions, pose));                       // the way so far, oldest first
//   view.model = model;                    // its points, pallets or areas are others
//
// host       a block element; the drawing is as wide as it and follows its width (from 240 px on)
// model      one entry of shapes(controller)
// positions  a number for each axis, pulses, or mm and degrees of the tool as a trace has them
// pose       the entry of poses(controller) beside it; what is left out is as at first: {}
// place      [x, y, z, r] of the tool in the robot's own coordinates, mm and degrees
//
// Colours are the page's: --ink, --soft, --line, --card, --link, --bad, --input, --output, --command,
// --curve, --a; where they are missing, those of a light page.

const SVG_SPACE = "http://www.w3.org/2000/svg";
const QUARTER = 90; // degrees of R where all joints are 0
const WIDE = 560; // from this width on both views stand side by side [px]
const GAP = 14;
const MOST_HIGH = 380; // of one view, where nothing else is said [px]
const BAR = 22;
const LONGEST_BAR = 640;
const TITLE = 38; // above the arm, for the name of the view
const CHARACTER = 6.3; // width of one [px]
const TALL = 13; // height of a label
const GRIDS = [10, 20, 50, 100, 200, 500, 1000];
const NO_POSE = {};
const STYLE = `
.rv text { font: 11px "DejaVu Sans", "Segoe UI", Arial, sans-serif; fill: var(--ink, #1d2733); }
.rv .rv-named { paint-order: stroke; stroke: var(--card, #fff); stroke-width: 3px; stroke-linejoin: round; }
.rv .rv-soft { fill: var(--soft, #566371); }
.rv .rv-back { fill: var(--card, #fff); stroke: var(--line, #d7dee6); }
.rv .rv-grid { stroke: var(--line, #d7dee6); stroke-width: 1; opacity: .7; }
.rv .rv-reach { fill: var(--link, #1a62ab); fill-opacity: .09; stroke: var(--link, #1a62ab); stroke-opacity: .45; }
.rv .rv-limit { stroke: var(--link, #1a62ab); stroke-opacity: .6; stroke-dasharray: 6 4; fill: none; }
.rv .rv-area { fill: var(--command, #6a4a8f); fill-opacity: .1; stroke: var(--command, #6a4a8f); stroke-dasharray: 3 2; }
.rv text.rv-of-area { fill: var(--command, #6a4a8f); }
.rv .rv-pallet { fill: none; stroke: var(--input, #1f5fa8); }
.rv .rv-work { fill: var(--input, #1f5fa8); }
.rv text.rv-of-pallet { fill: var(--input, #1f5fa8); }
.rv .rv-point { fill: var(--output, #1b7a3d); }
.rv text.rv-of-point { fill: var(--output, #1b7a3d); }
.rv .rv-trail { fill: none; stroke: var(--curve, #a03a6a); stroke-width: 1.5; stroke-linejoin: round; }
.rv .rv-base { fill: var(--soft, #566371); }
.rv .rv-arm { fill: none; stroke: var(--soft, #566371); stroke-linecap: round; opacity: .55; }
.rv .rv-fore { stroke: var(--link, #1a62ab); }
.rv .rv-joint { fill: var(--card, #fff); stroke: var(--ink, #1d2733); stroke-width: 1.5; }
.rv .rv-tool { fill: none; stroke: var(--a, #b34f00); stroke-width: 2.5; stroke-linecap: round; }
.rv .rv-tip { fill: var(--a, #b34f00); stroke: var(--card, #fff); stroke-width: 1.5; }
.rv .rv-rail { fill: var(--line, #d7dee6); }
.rv .rv-within { fill: var(--link, #1a62ab); }
.rv .rv-beyond { fill: var(--bad, #c62828); }
.rv .rv-value { font-variant-numeric: tabular-nums; }
.rv { display: block; max-width: 100%; }
`;

const radians = (degrees) => (degrees * Math.PI) / 180;
const degrees = (angle) => (angle * 180) / Math.PI;
const along = (length, angle) => [length * Math.cos(radians(angle)), length * Math.sin(radians(angle))];

function rotated([x, y], angle) {
  const [cosine, sine] = [Math.cos(radians(angle)), Math.sin(radians(angle))];
  return [x * cosine - y * sine, x * sine + y * cosine];
}

// Arms and hand as they count together: a hand beside the R axis of a SCARA robot is another arm 2.
function armsOf(model, { hand = [0, 0, 0, 0] }) {
  const [first, second, third, onR] = hand;
  if (model.kind !== "scara") return { tool: [first, second, third], turning: Boolean(onR) };
  const [arm1, arm2] = model.arms;
  if (onR) return { arm1, arm2, offset: 0, tool: [first, second, third], turning: true };
  return { arm1, arm2: arm2 + second, offset: first, tool: [0, 0, third], turning: false };
}

// The tool as seen from the flange whose R is r.
function toolAt(model, { tool, turning }, r) {
  const [x, y] = turning && model.axes.length > 3 ? rotated(tool, r) : tool;
  return [x, y, tool[2]];
}

// Where base, elbow, flange and tool are, from the joints (mm, degrees).
export function figure(model, joints, pose = NO_POSE) {
  const arms = armsOf(model, pose);
  const z = joints[2] ?? 0;
  let elbow = null;
  let flange = [joints[0], joints[1] ?? 0, z];
  let r = joints[3] ?? 0;
  if (model.kind === "scara") {
    const first = QUARTER + joints[0];
    const second = first + joints[1] + arms.offset;
    elbow = along(arms.arm1, first);
    const fore = along(arms.arm2, second);
    flange = [elbow[0] + fore[0], elbow[1] + fore[1], z];
    r = second - arms.offset + r;
  }
  const by = toolAt(model, arms, r);
  return { elbow, flange, r, tool: flange.map((value, k) => value + by[k]) };
}

// The tool's place of a position in mm: shifted coordinates become the robot's own.
function unshifted(model, [x, y = 0, z = 0, r = 0], { shift = [0, 0, 0, 0] }) {
  const [turnedX, turnedY] = rotated([x, y], model.axes.length > 1 ? shift[3] : 0);
  return [turnedX + shift[0], turnedY + shift[1], z + shift[2], r + shift[3]];
}

// The joints (mm, degrees) that bring the tool to a place; null where none do.
export function jointsAt(model, place, pose = NO_POSE) {
  const arms = armsOf(model, pose);
  const [, , , r] = place;
  const by = toolAt(model, arms, r);
  const [x, y, z] = place.slice(0, 3).map((value, k) => value - by[k]);
  if (model.kind !== "scara") return [x, y, z, r].slice(0, model.axes.length);
  const { arm1, arm2, offset } = arms;
  const cosine = (x * x + y * y - arm1 ** 2 - arm2 ** 2) / (2 * arm1 * arm2);
  if (Math.abs(cosine) > 1.001) return null;
  const bend = degrees(Math.acos(Math.min(1, Math.max(-1, cosine)))) * (pose.left ? -1 : 1);
  const [aheadX, aheadY] = along(arm2, bend);
  let first = degrees(Math.atan2(y, x) - Math.atan2(aheadY, arm1 + aheadX)) - QUARTER;
  first = ((((first + 180) % 360) + 360) % 360) - 180;
  let second = bend - offset; // a turned hand may bring it beyond half a turn
  if (Math.abs(second) > 180) second -= 360 * Math.round(second / 360);
  return [first, second, z, r - QUARTER - first - second].slice(0, model.axes.length);
}

// The joints of a position as a trace has it; further axes are as they are.
export function jointsOf(model, positions, unit, pose = NO_POSE) {
  if (unit === "pulses") return model.axes.map(({ per, zero }, k) => (positions[k] - zero) / per);
  const joints = jointsAt(model, unshifted(model, positions, pose), pose);
  return joints && [...joints, ...positions.slice(4, model.axes.length)];
}

function svgElement(tag, attributes = {}, text = "") {
  const made = document.createElementNS(SVG_SPACE, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text) made.textContent = text;
  return made;
}

const pathOf = (places) => places.map(([x, y], k) => `${k ? "L" : "M"}${x.toFixed(1)} ${y.toFixed(1)}`).join("");
const rounded = (value) => Number(value.toFixed(value % 1 ? 3 : 0));

// What the joints of a SCARA robot can reach: of each hand system its border.
function reachOf({ arms: [arm1, arm2], axes }) {
  const [[low1, high1], [low2, high2]] = axes.map(({ low, high }) => [low, Math.min(high, low + 360)]);
  const at = (first, second) => {
    const [x1, y1] = along(arm1, QUARTER + first);
    const [x2, y2] = along(arm2, QUARTER + first + second);
    return [x1 + x2, y1 + y2];
  };
  const steps = Array.from({ length: 61 }, (_, k) => k / 60);
  const from = (a, b) => steps.map((share) => a + (b - a) * share);
  const halves = [];
  for (const [near, far] of [[Math.max(0, low2), high2], [Math.min(0, high2), low2]]) {
    if (near === far || (far - near) * (far || near) < 0) continue;
    halves.push([
      ...from(low1, high1).map((one) => at(one, near)),
      ...from(near, far).map((one) => at(high1, one)),
      ...from(high1, low1).map((one) => at(one, far)),
      ...from(far, near).map((one) => at(low1, one)),
    ]);
  }
  return halves;
}

// One view: which part of the world it shows, and where that is on the screen.
class Pane {
  constructor(left, top, scale, box, flip) {
    Object.assign(this, { left, top, scale, box, flip });
    this.width = (box.right - box.left) * scale;
    this.height = (box.high - box.low) * scale;
  }

  x(value) {
    return this.left + (value - this.box.left) * this.scale;
  }

  y(value) {
    const from = this.flip ? this.box.high - value : value - this.box.low;
    return this.top + from * this.scale;
  }

  at([a, b]) {
    return [this.x(a), this.y(b)];
  }
}

export class RobotView {
  #host;
  #model;
  #unit;
  #high;
  #svg;
  #fixed = svgElement("g");
  #moving = svgElement("g");
  #bars = [];
  #panes = null;
  #laidOut = "";
  #last = [null, NO_POSE, []];
  static #numbers = 0;
  #number = (RobotView.#numbers += 1);

  constructor(host, model, { unit = "pulses", high = MOST_HIGH } = {}) {
    this.#host = host;
    this.#unit = unit;
    this.#high = high;
    this.#svg = svgElement("svg", { class: "rv", role: "img" });
    host.replaceChildren(this.#svg);
    this.model = model;
    new ResizeObserver(() => this.#draw()).observe(host);
  }

  set model(model) {
    this.#model = model;
    this.#laidOut = "";
    this.#draw();
  }

  get model() {
    return this.#model;
  }

  // [x, y, z, r] of the tool in the robot's own coordinates; null where no joints bring it there.
  place(positions, pose = NO_POSE) {
    const joints = jointsOf(this.#model, positions, this.#unit, pose);
    if (!joints) return null;
    const { tool, r } = figure(this.#model, joints, pose);
    return [...tool, r];
  }

  show(positions, pose = NO_POSE, trail = []) {
    this.#last = [positions, pose, trail];
    this.#draw();
  }

  #draw() {
    const [positions, pose, trail] = this.#last;
    const width = Math.max(240, Math.floor(this.#host.clientWidth));
    const key = `${width} ${pose.shift ?? ""}`;
    if (key !== this.#laidOut) {
      this.#laidOut = key;
      this.#layOut(width, pose);
    }
    const joints = positions && jointsOf(this.#model, positions, this.#unit, pose);
    this.#moving.replaceChildren();
    if (this.#panes) {
      this.#trail(trail);
      if (joints) this.#arm(figure(this.#model, joints, pose));
    }
    this.#axes(joints, positions);
    this.#tell(joints, pose);
  }

  #tell(joints, pose) {
    const { name, robot, kind } = this.#model;
    const who = `Robot ${robot}${name ? `, ${name}` : ""}`;
    if (!joints) return this.#svg.setAttribute("aria-label", `${who}: position not known`);
    const { tool, r } = figure(this.#model, joints, pose);
    const values = kind === "axes" ? joints : [...tool, r].slice(0, this.#model.axes.length);
    const letters = kind === "axes" ? ["1", "2", "3", "4", "5", "6"] : ["X", "Y", "Z", "R"];
    const words = values.map((value, k) => `${letters[k] ?? k + 1} ${rounded(value)}`);
    this.#svg.setAttribute("aria-label", `${who}: ${words.join(", ")}`);
  }

  // What does not move: views, limits, areas, pallets, points; anew for another width or shift.
  #layOut(width, pose) {
    const { kind } = this.#model;
    this.#fixed.replaceChildren();
    this.#panes = kind === "axes" ? null : this.#placed(width);
    let [bottom, barsTop, barsLeft, barsRight] = [0, 0, 0, Math.min(width, LONGEST_BAR)];
    if (this.#panes) {
      const [above, side] = this.#panes;
      bottom = Math.max(...this.#panes.map((pane) => pane.top + pane.height));
      barsTop = side.top + side.height + GAP;
      if (side.top === above.top) [barsLeft, barsRight] = [side.left, side.left + side.width];
      this.#ground(above, "from above: X right, Y front", "above");
      this.#ground(side, "from the side: X right, Z down", "side");
      this.#limits(above, side);
      this.#things(above, side, pose);
    }
    this.#bars = this.#model.axes.map((axis, k) => this.#bar(axis, k, barsTop + k * BAR, barsLeft, barsRight));
    const height = Math.ceil(Math.max(bottom, barsTop + this.#bars.length * BAR));
    for (const [name, value] of Object.entries({ width, height, viewBox: `0 0 ${width} ${height}` })) {
      this.#svg.setAttribute(name, value);
    }
    this.#svg.replaceChildren(svgElement("style", {}, STYLE), this.#fixed, this.#moving);
  }

  // Both views, to the same scale.
  #placed(width) {
    const { axes, kind } = this.#model;
    const [zLow, zHigh] = [axes[2]?.low ?? 0, axes[2]?.high ?? 0];
    let [left, right, low, high] = [axes[0].low, axes[0].high, axes[1]?.low ?? -50, axes[1]?.high ?? 50];
    if (kind === "scara") {
      const border = reachOf(this.#model).flat().concat([[0, 0]]);
      [left, right] = [Math.min(...border.map(([x]) => x)), Math.max(...border.map(([x]) => x))];
      [low, high] = [Math.min(...border.map(([, y]) => y)), Math.max(...border.map(([, y]) => y))];
    }
    const room = Math.max(right - left, high - low) * 0.07;
    const box = { left: left - room, right: right + room };
    const above = { ...box, low: low - room, high: high + room };
    const wide = width >= WIDE;
    const across = wide ? (width - GAP) / 2 : width;
    const scale = Math.min(across / (box.right - box.left), this.#high / (above.high - above.low));
    const most = wide ? Math.min(across / scale, (box.right - box.left) * 1.4) : across / scale;
    const beyond = Math.max(0, most - (box.right - box.left)) / 2; // for names beside the limits
    for (const one of [box, above]) {
      one.left -= beyond;
      one.right += beyond;
    }
    const side = { ...box, low: zLow - this.#head * 1.3 - TITLE / scale, high: zHigh + room * 1.3 };
    const first = new Pane(0, 0, scale, above, true);
    const beside = wide ? [first.width + GAP, 0] : [0, first.height + GAP];
    return [first, new Pane(...beside, scale, side, false)];
  }

  // How far the arm is drawn above the upper end of Z [mm]; no source gives it.
  get #head() {
    const { arms, axes, kind } = this.#model;
    return kind === "scara" ? (arms[0] + arms[1]) * 0.1 : (axes[0].high - axes[0].low) * 0.08;
  }

  #ground(pane, title, name) {
    const id = `rv${this.#number}${name}`;
    const about = { x: pane.left, y: pane.top, width: pane.width, height: pane.height };
    const clip = svgElement("clipPath", { id });
    clip.append(svgElement("rect", about));
    this.#fixed.append(clip, svgElement("rect", { ...about, class: "rv-back" }));
    pane.clip = `url(#${id})`;
    const { box, scale } = pane;
    const step = GRIDS.find((one) => one * scale >= 45) ?? 2000;
    for (let x = Math.ceil(box.left / step) * step; x <= box.right; x += step) {
      this.#line(pane, "rv-grid", [pane.x(x), pane.top], [pane.x(x), pane.top + pane.height]);
      const text = String(x);
      if (pane.x(x) + 2 + text.length * CHARACTER > pane.left + pane.width) continue; // it would be cut
      this.#text(pane.x(x) + 2, pane.top + pane.height - 4, text, "rv-soft");
    }
    for (let y = Math.ceil(box.low / step) * step; y <= box.high; y += step) {
      this.#line(pane, "rv-grid", [pane.left, pane.y(y)], [pane.left + pane.width, pane.y(y)]);
      if (Math.abs(pane.y(y) - pane.top - pane.height) > 24 && pane.y(y) > pane.top + 30) {
        this.#text(pane.left + 3, pane.y(y) - 3, String(y), "rv-soft");
      }
    }
    this.#text(pane.left + 6, pane.top + 15, `${title} [mm]`, "rv-soft");
    pane.labels = [{ x: pane.left, y: pane.top, right: pane.left + 200, bottom: pane.top + 20 }];
  }

  #line(pane, name, from, to, into = this.#fixed) {
    const path = svgElement("path", { class: name, d: pathOf([from, to]), "clip-path": pane.clip });
    into.append(path);
    return path;
  }

  #text(x, y, text, name = "", into = this.#fixed) {
    const made = svgElement("text", { x: x.toFixed(1), y: y.toFixed(1), class: name }, text);
    into.append(made);
    return made;
  }

  // The limits of the joints: what can be reached, and how far Z goes.
  #limits(above, side) {
    const { axes, kind } = this.#model;
    const [first, second, third] = axes;
    const corners = [
      [first.low, second?.low ?? 0], [first.high, second?.low ?? 0],
      [first.high, second?.high ?? 0], [first.low, second?.high ?? 0],
    ];
    const borders = kind === "scara" ? reachOf(this.#model) : [corners];
    const d = borders.map((one) => `${pathOf(one.map((place) => above.at(place)))}Z`).join("");
    this.#fixed.append(svgElement("path", { class: "rv-reach", d, "clip-path": above.clip }));
    for (const z of third ? [third.low, third.high] : []) {
      const [left, right] = [side.x(side.box.left), side.x(side.box.right)];
      this.#line(side, "rv-limit", [left, side.y(z)], [right, side.y(z)]);
    }
  }

  // Areas, pallets and points, each with its name where there is room for it.
  #things(above, side, pose) {
    const { areas = [], pallets = [], points = [] } = this.#model;
    const moved = (place) => unshifted(this.#model, place, pose);
    for (const { name, from, to } of areas) {
      const [x1, x2] = [Math.min(from[0], to[0]), Math.max(from[0], to[0])];
      const [y1, y2] = [Math.min(from[1], to[1]), Math.max(from[1], to[1])];
      this.#box(above, "rv-area", [[x1, y1], [x2, y1], [x2, y2], [x1, y2]], name);
      this.#label(above, [x1, y2], name, "rv-of-area", [[3, TALL]]);
      if (from.length < 3) continue;
      this.#box(side, "rv-area", [[x1, from[2]], [x2, from[2]], [x2, to[2]], [x1, to[2]]], name);
      this.#label(side, [x1, Math.min(from[2], to[2])], name, "rv-of-area", [[3, TALL]]);
    }
    for (const { number, corners, places } of pallets) {
      const name = `Pallet ${number}`;
      const all = corners.map(moved);
      this.#box(above, "rv-pallet", all, name);
      this.#box(side, "rv-pallet", all.map(([x, , z]) => [x, z]), name);
      for (const place of places.map(moved)) {
        const [cx, cy] = above.at(place);
        this.#fixed.append(svgElement("circle", { class: "rv-work", cx, cy, r: 1.8, "clip-path": above.clip }));
      }
      const beside = [[6, TALL], [6, 4], [-6 - name.length * CHARACTER, 4], [0, -7]];
      if (!this.#label(above, all[2], name, "rv-of-pallet", beside)) {
        this.#label(above, all[0], name, "rv-of-pallet", [[0, TALL + 5], ...beside]);
      }
    }
    for (const { number, name, mm, joints } of points) {
      const place = mm ? moved(mm) : figure(this.#model, joints, pose).tool;
      const text = name ? `P${number} ${name}` : `P${number}`;
      const size = text.length * CHARACTER;
      const around = [[6, 4], [-6 - size, 4], [-size / 2, -7], [-size / 2, 17]];
      for (const [pane, at] of [[above, place], [side, [place[0], place[2]]]]) {
        this.#mark(pane, at, text);
        this.#label(pane, at, text, "rv-of-point", around);
      }
    }
  }

  #box(pane, name, corners, title) {
    const d = `${pathOf(corners.map((one) => pane.at(one)))}Z`;
    const path = svgElement("path", { class: name, d, "clip-path": pane.clip });
    path.append(svgElement("title", {}, title));
    this.#fixed.append(path);
  }

  #mark(pane, place, title) {
    const [x, y] = pane.at(place);
    const d = `M${x} ${y - 4}L${x + 4} ${y}L${x} ${y + 4}L${x - 4} ${y}Z`;
    const path = svgElement("path", { class: "rv-point", d, "clip-path": pane.clip });
    path.append(svgElement("title", {}, title));
    this.#fixed.append(path);
  }

  // At the first of some offsets where it covers no other; else nowhere, for there is a tip.
  #label(pane, place, text, name, offsets) {
    const [atX, atY] = pane.at(place);
    const width = text.length * CHARACTER;
    for (const [byX, byY] of offsets) {
      const [x, y] = [atX + byX, atY + byY];
      const box = { x, y: y - TALL + 3, right: x + width, bottom: y + 3 };
      const inside =
        box.x >= pane.left && box.right <= pane.left + pane.width && box.y >= pane.top && box.bottom <= pane.top + pane.height;
      const covers = pane.labels.some(
        (one) => box.x < one.right && one.x < box.right && box.y < one.bottom && one.y < box.bottom,
      );
      if (!inside || covers) continue;
      pane.labels.push(box);
      this.#text(x, y, text, `rv-named ${name}`);
      return true;
    }
    return false;
  }

  #trail(trail) {
    const [above, side] = this.#panes;
    const places = trail.filter(Boolean);
    if (places.length < 2) return;
    for (const [pane, at] of [[above, ([x, y]) => [x, y]], [side, ([x, , z]) => [x, z]]]) {
      const d = pathOf(places.map((place) => pane.at(at(place))));
      this.#moving.append(svgElement("path", { class: "rv-trail", d, "clip-path": pane.clip }));
    }
  }

  #arm({ elbow, flange, r, tool }) {
    const [above, side] = this.#panes;
    const wide = Math.max(5, Math.min(26, above.scale * 60));
    const add = (pane, tag, name, about) =>
      this.#moving.append(svgElement(tag, { class: name, "clip-path": pane.clip, ...about }));
    const link = (pane, from, to, name, width = wide) =>
      add(pane, "path", name, { d: pathOf([pane.at(from), pane.at(to)]), "stroke-width": width });
    const dot = (pane, place, radius, name) => {
      const [cx, cy] = pane.at(place);
      add(pane, "circle", name, { cx, cy, r: radius });
    };
    const { axes } = this.#model;
    const [x, y, z] = flange;
    const upper = axes[2]?.low ?? 0;
    const head = this.#head;
    if (elbow) {
      const [high, lower] = [upper - head * 1.3, upper - head * 0.7];
      dot(above, [0, 0], wide * 0.8, "rv-base");
      link(above, [0, 0], elbow, "rv-arm");
      link(above, elbow, [x, y], "rv-arm rv-fore");
      dot(above, elbow, 4, "rv-joint");
      link(side, [0, side.box.high], [0, high], "rv-arm", wide * 1.3);
      link(side, [0, high], [elbow[0], high], "rv-arm");
      link(side, [elbow[0], lower], [x, lower], "rv-arm rv-fore");
      link(side, [x, lower], [x, z], "rv-arm rv-fore", wide / 2.5);
    } else {
      const [{ low, high }, across = { low: 0, high: 0 }] = axes;
      link(above, [low, across.low], [high, across.low], "rv-arm");
      link(above, [x, across.low], [x, across.high], "rv-arm rv-fore");
      link(side, [low, upper - head], [high, upper - head], "rv-arm");
      link(side, [x, upper - head], [x, z], "rv-arm rv-fore", wide / 2.5);
    }
    dot(above, [x, y], 5, "rv-joint");
    if (axes.length > 3) {
      const [turnX, turnY] = along(22 / above.scale, r);
      link(above, [x, y], [x + turnX, y + turnY], "rv-tool", 1.5);
    }
    link(above, [x, y], tool, "rv-tool", 2.5);
    link(side, [x, z], [tool[0], z], "rv-tool", 2.5);
    link(side, [tool[0], z], [tool[0], tool[2]], "rv-tool", 2.5);
    dot(above, tool, 4, "rv-tip");
    dot(side, [tool[0], tool[2]], 4, "rv-tip");
  }

  // An axis between its soft limits, and where it is.
  #bar(axis, k, top, begin, end) {
    const [left, right] = [begin + 52, end - 100];
    this.#text(begin, top + 15, `Axis ${k + 1}`);
    const about = { class: "rv-rail", x: left, y: top + 8, width: right - left, height: 6, rx: 3 };
    const rail = svgElement("rect", about);
    const unit = axis.unit === "deg" ? "°" : " mm";
    rail.append(svgElement("title", {}, `soft limits ${rounded(axis.low)}${unit} to ${rounded(axis.high)}${unit}`));
    const mark = svgElement("circle", { cy: top + 11, r: 5.5 });
    const value = this.#text(end, top + 15, "", "rv-value");
    value.setAttribute("text-anchor", "end");
    this.#fixed.append(rail, mark);
    return { mark, value, left, right, unit };
  }

  #axes(joints, positions) {
    for (const [k, { mark, value, left, right, unit }] of this.#bars.entries()) {
      const { low, high } = this.#model.axes[k];
      const at = joints?.[k];
      const known = Number.isFinite(at);
      mark.setAttribute("visibility", known ? "visible" : "hidden");
      const pulses = known && this.#model.kind === "axes" && this.#unit === "pulses";
      value.textContent = known ? (pulses ? `${positions[k]} pulses` : `${at.toFixed(2)}${unit}`) : "–";
      if (!known) continue;
      const share = Math.min(1, Math.max(0, (at - low) / (high - low)));
      mark.setAttribute("cx", (left + share * (right - left)).toFixed(1));
      mark.setAttribute("class", at < low - 1e-3 || at > high + 1e-3 ? "rv-beyond" : "rv-within");
    }
  }
}
