// Finding events: "next SO(13) edge", "alarm", "MovePtp", "Main.Stage := PICK_OPEN".

const IDLE_WORDS = new Set(["next", "previous", "prev", "edge", "edges", "change", "changes", "the", "of"]);
const BIT = /^(s[io])\(?(\d{2})\)?$/;

// The words that an event has to have: "SO13 on" looks for "so(13)" and "on".
export function wordsOf(query) {
  return query
    .toLowerCase()
    .split(/\s+/)
    .filter((word) => word && !IDLE_WORDS.has(word))
    .map((word) => word.replace(BIT, "$1($2)"));
}

const LEVEL = /^\S+ (on|off)\b|:= (true|false)$/;
const SAME = { true: "on", false: "off" };

// Says of an event's text whether a query finds it. "on" and "off" are the level that a signal or
// variable has gone to, wherever else these words are in its name.
export function matcher(query) {
  const words = wordsOf(query).map((word) => SAME[word] ?? word);
  return (text) => {
    const plain = text.toLowerCase();
    const found = LEVEL.exec(plain) ?? [];
    const level = found[1] ?? SAME[found[2]];
    return words.every((word) => (word === "on" || word === "off" ? word === level : plain.includes(word)));
  };
}

// The numbers of the events whose lane is wanted and whose text a query finds. A text is judged
// once for each value of each lane, however often it comes.
export function find(events, query, wanted = () => true) {
  const fits = matcher(query);
  const known = new Map();
  const found = [];
  for (let k = 0; k < events.count; k++) {
    const lane = events.lane(k);
    if (!wanted(lane)) continue;
    const key = `${lane.number} ${lane.value(events.which[k])}`;
    let is = known.get(key);
    if (is === undefined) known.set(key, (is = fits(events.text(k))));
    if (is) found.push(k);
  }
  return Int32Array.from(found);
}

// The place in `found` of the first event behind a time, or of the last one before it; at the end
// it goes on from the beginning. -1 where nothing was found.
export function step(events, found, t, direction) {
  if (!found.length) return -1;
  if (direction > 0) {
    const place = found.findIndex((k) => events.time(k) > t);
    return place < 0 ? 0 : place;
  }
  const place = found.findLastIndex((k) => events.time(k) < t);
  return place < 0 ? found.length - 1 : place;
}
