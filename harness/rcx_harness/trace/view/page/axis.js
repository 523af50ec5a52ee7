// The time axis: which time is where, and what the cursors say. Times are in microseconds.

const SHORTEST = 50; // a chart shows no less than so many microseconds
const STEPS = [1, 2, 5];

export class Axis {
  // `room` is left at both ends, as a share of the whole: what happens there is to be seen, too.
  constructor(begin, end, room = 0) {
    room = Math.max((end - begin) * room, 0);
    this.begin = begin - room;
    this.end = end + room;
    this.width = 1000;
    this.fit();
  }

  get span() {
    return this.to - this.from;
  }

  x(t) {
    return ((t - this.from) / this.span) * this.width;
  }

  t(x) {
    return this.from + (x / this.width) * this.span;
  }

  // Shows this much, as far as there is something.
  show(from, to) {
    const whole = this.end - this.begin;
    const span = Math.min(Math.max(to - from, Math.min(SHORTEST, whole)), whole);
    const middle = (from + to) / 2;
    this.from = Math.min(Math.max(middle - span / 2, this.begin), this.end - span);
    this.to = this.from + span;
  }

  fit() {
    this.show(this.begin, this.end);
  }

  // A factor below 1 shows less; the time at x stays where it is.
  zoom(factor, x = this.width / 2) {
    const at = this.t(x);
    const from = at - (at - this.from) * factor;
    const span = this.span * factor;
    this.show(from, from + span);
    this.pan(at - this.t(x));
  }

  pan(by) {
    this.show(this.from + by, this.to + by);
  }

  // Brings a time into view where it is not, with what is around it.
  reveal(t, margin = 0.1) {
    const room = this.span * margin;
    if (t < this.from + room || t > this.to - room) this.show(t - this.span / 2, t + this.span / 2);
  }
}

// Round times to mark: at least `apart` pixels from one to the next.
export function ticks(axis, apart) {
  const least = (axis.span / axis.width) * apart;
  const power = 10 ** Math.floor(Math.log10(least));
  const step = Math.max(1, [...STEPS, 10].map((one) => one * power).find((one) => one >= least * 0.999));
  const times = [];
  for (let t = Math.ceil(axis.from / step) * step; t <= axis.to; t += step) times.push(t);
  return { step, times };
}

// A time in seconds, with as many decimals as a step needs.
export function seconds(t, step = 1) {
  const decimals = Math.min(6, Math.max(0, Math.ceil(6 - Math.log10(Math.max(step, 1)) - 1e-9)));
  return `${(t / 1e6).toFixed(decimals)} s`;
}

// How long something is, in the unit that people would say it in.
export function duration(us) {
  const size = Math.abs(us);
  const short = (value) => String(Number(value.toFixed(3)));
  if (size < 1000) return `${short(us)} µs`;
  return size < 1e6 ? `${short(us / 1000)} ms` : `${short(us / 1e6)} s`;
}

// The change nearest to t, if it is not further than `most`; else t, in whole microseconds.
export function snapped(lanes, t, most) {
  let found = Math.round(t);
  let distance = most;
  for (const lane of lanes) {
    const before = lane.indexAt(t);
    for (const index of [before, before + 1]) {
      const time = lane.times[index];
      if (time !== undefined && Math.abs(time - t) < distance) {
        distance = Math.abs(time - t);
        found = time;
      }
    }
  }
  return found;
}

// The change of a lane before or behind a time; undefined where there is none.
export function neighbour(lane, t, direction) {
  const index = lane.indexAt(direction > 0 ? t : t - 1e-3);
  return lane.times[direction > 0 ? index + 1 : index];
}
