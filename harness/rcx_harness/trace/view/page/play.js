// Playing a run: the time moves on as a clock does, faster or slower.

// The time that is reached [us]: `elapsed` ms after it was started at `from`, but not beyond `end`.
export function reached(from, elapsed, pace, end) {
  return Math.min(from + elapsed * 1000 * pace, end);
}

export class Player {
  #clock;
  #onTime;
  #onState;
  #number = 0; // of the play: a frame of an earlier play does nothing
  playing = false;

  // `clock(callback)` calls back before the next frame with a time in ms; `onTime(t)` shows a time;
  // `onState()` is called when playing starts or ends.
  constructor(clock, onTime, onState) {
    this.#clock = clock;
    this.#onTime = onTime;
    this.#onState = onState;
  }

  start(from, end, pace) {
    const number = ++this.#number;
    let began = null;
    this.playing = true;
    this.#onState();
    const frame = (now) => {
      if (number !== this.#number) return;
      began ??= now;
      const t = reached(from, now - began, pace, end);
      this.#onTime(t);
      if (t < end) this.#clock(frame);
      else this.stop();
    };
    this.#clock(frame);
  }

  stop() {
    if (!this.playing) return;
    this.#number += 1;
    this.playing = false;
    this.#onState();
  }
}
