// Runs jobs in a separate Python, so the page always responds.
// Receives { id, job }. Sends { loaded } with a share while it loads, { ready }, { id, share },
// { id, told }, { id, trace }, { failed }.
import { loadPyodide } from "./python/pyodide.mjs";

const BEGIN = `
import os, pathlib, sys
sys.path.insert(0, "/rcx/harness")
from rcx_tools.site.drive import Runner
runner = Runner(pathlib.Path("/cell"))
`;

// Number of bytes that this worker fetches; the build writes the number.
const BYTES = Number("@BYTES@");

const say = (message) => self.postMessage(message);

/** Report the received share of the bytes that this worker fetches. */
function reportFetches() {
  const fetched = self.fetch;
  let received = 0;
  let reported = 0;
  self.fetch = async (...given) => {
    const answer = await fetched(...given);
    if (!answer.ok || !answer.body) return answer;
    const counted = new TransformStream({
      transform(piece, to) {
        received += piece.byteLength;
        const share = Math.min(1, received / BYTES);
        if (share - reported >= 0.01) say({ loaded: (reported = share) });
        to.enqueue(piece);
      },
    });
    const { status, statusText, headers } = answer;
    return new Response(answer.body.pipeThrough(counted), { status, statusText, headers });
  };
}

async function begin() {
  reportFetches();
  const archive = fetch("./harness.zip").then((answer) => {
    if (!answer.ok) throw new Error(`harness.zip: ${answer.status}`);
    return answer.arrayBuffer();
  });
  const python = await loadPyodide({ env: { HOME: "/home", XDG_CACHE_HOME: "/rcx/cache" } });
  python.unpackArchive(await archive, "zip", { extractDir: "/rcx" });
  python.runPython(BEGIN);
  say({ ready: true });
  return python;
}

const started = begin();
started.catch((error) => say({ failed: last(error) }));

self.onmessage = async ({ data }) => {
  const python = await started;
  const runner = python.globals.get("runner");
  try {
    if (data.trace) {
      say({ id: data.id, trace: runner.trace() });
      return;
    }
    const told = runner.run(data.job, (share) => say({ id: data.id, share }));
    python.runPython(`os.environ["RCX_CACHE"] = "off"`); // an edited program is not cached
    say({ id: data.id, told });
  } catch (error) {
    say({ id: data.id, failed: last(error) });
  }
};

/** The last line of a traceback, else the message. */
function last(error) {
  return String(error.message).trim().split("\n").at(-1);
}
