// Convert a job to the fragment of a link and back: compressed JSON in characters for URLs.

const FORM = "deflate-raw";

export async function packed(job) {
  const bytes = await through(new CompressionStream(FORM), new TextEncoder().encode(JSON.stringify(job)));
  let text = "";
  for (const byte of bytes) text += String.fromCharCode(byte);
  return btoa(text).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

/** Return the job in the text; throw an Error if the text contains no complete job. */
export async function unpacked(text) {
  const letters = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
  const job = JSON.parse(new TextDecoder().decode(await through(new DecompressionStream(FORM), bytes)));
  if (!isJob(job)) throw new Error("no program");
  return job;
}

function isJob(job) {
  const texts = (every) => every.every((one) => typeof one === "string");
  const moment = (one) => Array.isArray(one) && Number.isInteger(one[0]) && typeof one[1] === "string";
  return Boolean(job) && typeof job.title === "string"
    && Boolean(job.files) && texts(Object.values(job.files)) && Object.keys(job.files).every(isName)
    && Array.isArray(job.robots) && texts(job.robots)
    && Array.isArray(job.stimulus) && job.stimulus.every(moment)
    && [job.scan, job.rpi, job.for].every(Number.isInteger)
    && [job.size ?? 48, ...(job.m ?? []), ...(job.n ?? [])].every(Number.isInteger);
}

const isName = (name) => /^\w[\w.-]*\.st$/i.test(name);

async function through(stream, bytes) {
  const answer = new Response(new Blob([bytes]).stream().pipeThrough(stream));
  return new Uint8Array(await answer.arrayBuffer());
}
