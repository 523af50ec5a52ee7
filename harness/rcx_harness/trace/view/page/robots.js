// The robots of a recording, as they stand at a time: each a drawing of its own.

import { element } from "./chart.js";
import { RobotView } from "./robot.js";

const WAY = 3000; // positions that are drawn of the way until then: 15 s of motion

export class Robots {
  #robots;

  // `entries` as in the table of the page, `lanes` all lanes; a view is at most `high` [px].
  constructor(host, entries, lanes, high) {
    this.#robots = entries.map(({ title, unit, model, lanes: own, poses }) => {
      const box = element("div", { class: "robot" });
      host.append(element("h2", {}, title), box);
      const view = new RobotView(box, model, { unit, high });
      return { view, lanes: own.map((k) => lanes[k]), poses };
    });
  }

  show(t) {
    for (const { view, lanes, poses } of this.#robots) {
      const positions = lanes.map((lane) => lane.value(lane.indexAt(t)));
      view.show(positions, poseAt(poses, t), wayUntil(view, lanes, poses, t));
    }
  }
}

export function poseAt(poses, t) {
  const place = poses.findLastIndex(([since]) => since <= t);
  return place < 0 ? {} : poses[place][1];
}

// The times of the last changes of some lanes, the earliest first.
export function lastTimes(lanes, t, most) {
  const all = lanes.flatMap((lane) => {
    const end = lane.indexAt(t) + 1;
    return [...lane.times.subarray(Math.max(0, end - most), end)];
  });
  return [...new Set(all)].sort((one, other) => one - other).slice(-most);
}

// Where the tool has been until t.
function wayUntil(view, lanes, poses, t) {
  const times = view.model.kind === "axes" ? [] : lastTimes(lanes, t, WAY);
  if (!times.length) return [];
  const at = lanes.map((lane) => lane.indexAt(times[0]));
  return times.map((time) => {
    const positions = lanes.map((lane, k) => {
      while (at[k] + 1 < lane.times.length && lane.times[at[k] + 1] <= time) at[k] += 1;
      return lane.value(at[k]);
    });
    return view.place(positions, poseAt(poses, time));
  });
}
