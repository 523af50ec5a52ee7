// What the page was given: lanes with their changes, and the order of all events.
// The bytes are those that pack.py has written.

const BLOCK = 64; // samples in a piece of which the least and the greatest value are known
const OTHER = { nan: NaN, inf: Infinity, "-inf": -Infinity };

export async function unpack(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const length = new DataView(bytes.buffer).getUint32(0, true);
  const table = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + length)));
  return { table, bytes: bytes.subarray(4 + length) };
}

// Reads numbers one after the other, from byte `at` on. Not with shifts: they would end at 32 bits.
export function reader(bytes, at = 0) {
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  const whole = () => {
    const first = bytes[at++];
    if (first < 128) return first;
    let value = first & 127;
    for (let factor = 128; ; factor *= 128) {
      const byte = bytes[at++];
      value += (byte & 127) * factor;
      if (byte < 128) return value;
    }
  };
  const signed = () => {
    const value = whole();
    return value % 2 ? -(value + 1) / 2 : value / 2;
  };
  const real = () => view.getFloat64((at += 8) - 8, true);
  return { whole, signed, real };
}

// How many of the sorted times are not later than t.
export function countUntil(times, t) {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle + 1;
    else high = middle;
  }
  return low;
}

// One line of the chart. A change k is at times[k] and goes to values[k]; before the first of them,
// number -1, the value is `first`. Its bytes are read when it is first looked at.
export class Lane {
  #bytes;
  #lanes;
  #read = null;
  #levels = null;

  constructor(entry, number, bytes, lanes, texts, cycle) {
    Object.assign(this, { number, texts, cycle }, entry);
    if (typeof this.first === "string") this.first = OTHER[this.first];
    this.#bytes = bytes;
    this.#lanes = lanes;
  }

  get times() {
    return this.#changes().times;
  }

  get values() {
    return this.#changes().values;
  }

  #changes() {
    this.#read ??= this.speedOf === undefined ? this.#decoded() : speed(this.#lanes[this.speedOf]);
    return this.#read;
  }

  #decoded() {
    const { whole, signed, real } = reader(this.#bytes, this.at[0]);
    const times = new Float64Array(this.count);
    const values = this.form === "bit" ? null : new Float64Array(this.count);
    let time = 0;
    let value = this.first ?? 0;
    const next = { whole: () => value + signed(), real, text: whole }[this.form];
    const parts = this.fine ?? 1;
    for (let k = 0; k < times.length; k++) {
      times[k] = time += whole();
      if (values) values[k] = (value = next()) / parts;
    }
    return { times, values };
  }

  // The last change until t; -1 where there is none.
  indexAt(t) {
    return countUntil(this.times, t) - 1;
  }

  value(index) {
    if (this.form === "bit" && this.speedOf === undefined) {
      return Number(Boolean(this.first) !== (index % 2 === 0));
    }
    if (index >= 0) return this.values[index];
    return this.fine ? this.first / this.fine : this.first ?? 0;
  }

  // Is there anything to see of it but OFF?
  get tells() {
    if (this.speedOf !== undefined) return this.#lanes[this.speedOf].count > 0;
    return this.count > 0 || Boolean(this.first);
  }

  // A value as it stands in the chart.
  text(value) {
    if (value === null || value === undefined) return "";
    if (this.form === "text") return this.texts[value] ?? "";
    if (this.form === "bit" && this.speedOf === undefined) {
      return this.colour === "variable" ? (value ? "TRUE" : "FALSE") : value ? "ON" : "OFF";
    }
    if (this.digits) return `16#${value.toString(16).toUpperCase().padStart(this.digits, "0")}`;
    if (this.speedOf !== undefined) return String(Number(value.toFixed(1)));
    if (this.precision && Number.isFinite(value)) return String(Number(value.toPrecision(this.precision)));
    return String(value);
  }

  // What happened with a change, in words.
  told(index) {
    const text = this.text(this.value(index));
    if (this.form === "bit" && this.colour !== "variable") {
      return `${this.short} ${text.padEnd(3)}  ${this.name.slice(this.short.length + 1)}`.trimEnd();
    }
    if (this.colour === "variable") return `${this.name} := ${text}`;
    return this.short ? `${this.short} ${text}` : text;
  }

  // The least and the greatest of the values from number `begin` on, before number `end`.
  span(begin, end) {
    this.#levels ??= levels(this.values);
    let low = Infinity;
    let high = -Infinity;
    const take = (some, from, to) => {
      for (let k = from; k < to; k++) {
        if (some.low[k] < low) low = some.low[k];
        if (some.high[k] > high) high = some.high[k];
      }
    };
    for (const level of this.#levels) {
      const first = Math.ceil(begin / BLOCK) * BLOCK;
      const last = Math.floor(end / BLOCK) * BLOCK;
      if (first >= last || level === this.#levels.at(-1)) {
        take(level, begin, end);
        break;
      }
      take(level, begin, first);
      take(level, last, end);
      [begin, end] = [first / BLOCK, last / BLOCK];
    }
    return [low, high];
  }

  // The same of the whole run.
  get limits() {
    const first = this.value(-1);
    const [low, high] = this.span(0, this.values.length);
    return Number.isFinite(first) ? [Math.min(low, first), Math.max(high, first)] : [low, high];
  }
}

// Least and greatest of the values one by one, of blocks of them, of blocks of blocks ...
function levels(values) {
  const found = [{ low: values, high: values }];
  while (found.at(-1).low.length > BLOCK) {
    const { low, high } = found.at(-1);
    const size = Math.ceil(low.length / BLOCK);
    const next = { low: new Float64Array(size).fill(Infinity), high: new Float64Array(size).fill(-Infinity) };
    for (let k = 0; k < low.length; k++) {
      const block = (k / BLOCK) | 0;
      if (low[k] < next.low[block]) next.low[block] = low[k];
      if (high[k] > next.high[block]) next.high[block] = high[k];
    }
    found.push(next);
  }
  return found;
}

// The speed of a position, in its units a second. A position is noted in the cycle in which it is
// another: it has gone there within that cycle, and rests until the next one is noted.
export function speed(position) {
  const { times: at, values: where, cycle } = position;
  const times = new Float64Array(2 * at.length);
  const values = new Float64Array(2 * at.length);
  let count = 0;
  const note = (t, value) => {
    if (count && times[count - 1] === t) count -= 1;
    if (value === (count ? values[count - 1] : 0)) return;
    times[count] = t;
    values[count++] = value;
  };
  let before = position.value(-1);
  let since = -Infinity;
  for (let k = 0; k < at.length; k++) {
    const from = Math.max(at[k] - cycle, since);
    if (at[k] > from) note(from, ((where[k] - before) / (at[k] - from)) * 1e6);
    if (k + 1 === at.length || at[k + 1] - cycle > at[k]) note(at[k], 0);
    before = where[k];
    since = at[k];
  }
  return { times: times.slice(0, count), values: values.slice(0, count) };
}

// Every change that is told of, from the first to the last: their lanes stand at byte `at`.
export class Events {
  constructor(lanes, bytes, { at, count }) {
    this.lanes = lanes;
    const last = new Int32Array(lanes.length).fill(-1);
    this.whose = new Int32Array(count);
    this.which = new Int32Array(count);
    const { whole } = reader(bytes, at);
    for (let k = 0; k < count; k++) {
      this.whose[k] = whole();
      this.which[k] = last[this.whose[k]] += 1;
    }
  }

  get count() {
    return this.whose.length;
  }

  lane(k) {
    return this.lanes[this.whose[k]];
  }

  time(k) {
    return this.lane(k).times[this.which[k]];
  }

  text(k) {
    return this.lane(k).told(this.which[k]);
  }

  // How many events are not later than t.
  countUntil(t) {
    let low = 0;
    let high = this.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.time(middle) <= t) low = middle + 1;
      else high = middle;
    }
    return low;
  }
}
